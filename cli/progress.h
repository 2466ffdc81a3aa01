// SPDX-License-Identifier: MIT
// A line on the terminal that tells how far long work is: its rate and the
// time left. Nothing is shown where stderr is not a terminal.
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct progress {
    const char *what; // "step", "launch"
    uint64_t total;   // 0: not known
    uint64_t begun_ns;
    uint64_t shown_ns;
    bool on_terminal;
} progress;

progress progress_begin(const char *what, uint64_t total);
// Shows "what done of total, rate, time left", at most ten times a second.
void progress_show(progress *p, uint64_t done);
void progress_end(progress *p); // clears the line

#endif
