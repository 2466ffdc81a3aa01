// SPDX-License-Identifier: MIT
// Ctrl-C: long work asks between two steps whether to stop, so that what was
// done so far is kept. A second Ctrl-C ends the program at once.
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include "duet_error.h"

#include <stdbool.h>

void interrupt_watch(void);
bool interrupt_asked(void);
void interrupt_forget(void); // what was asked so far: for a person who goes on typing

// false with INTERRUPTED once Ctrl-C was pressed.
bool interrupt_check(duet_error *err);

// For work that loses nothing by it: from here on the program ends by itself 1.5 s
// after Ctrl-C, whatever it then does, as a long compilation.
void interrupt_insist(void);

// Ends the program by the signal that asked it to, so that a shell's loop ends too.
// Comes back where none did.
void interrupt_die(void);

// The last resort against a script that does not end: ends the program, with a
// line, where a script of the calling thread is still there 2 s after its limit of
// time (exit status 1), or 1.5 s after Ctrl-C or SIGTERM (by that signal). The library never does
// that: it ends the script, which an application survives.
void interrupt_guard_scripts(void);

#endif
