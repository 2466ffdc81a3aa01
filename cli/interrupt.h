// SPDX-License-Identifier: MIT
// Ctrl-C: long work asks between two steps whether to stop, so that what was
// done so far is kept. A second Ctrl-C ends the program at once.
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

void interrupt_watch(void);
bool interrupt_asked(void);
uint64_t interrupt_age_ns(void); // how long ago that was; 0: not asked
void interrupt_forget(void);     // what was asked so far: for a person who goes on typing

// false with INTERRUPTED once Ctrl-C was pressed.
bool interrupt_check(duet_error *err);

#endif
