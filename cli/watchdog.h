// SPDX-License-Identifier: MIT
// The last resort against a script that does not end: ends the program, with a
// line and exit status 1, where the script that runs is still there 2 s after
// its limit of time, or 1.5 s after Ctrl-C or SIGTERM. The library never does
// that: it ends the script, which an application survives.
#ifndef CLI_WATCHDOG_H
#define CLI_WATCHDOG_H

// Begins to watch the scripts of the calling thread.
void watchdog_start(void);

#endif
