// SPDX-License-Identifier: MIT
// Ctrl-C, SIGTERM and SIGHUP: long work asks between two steps whether to stop, so that
// what was done so far is kept. Work that does not ask is ended 1.5 s later unless it is awaited,
// and a second Ctrl-C ends all at once; what is half-written is removed first.
//
// The program then ends by the signal itself, not by an exit status: so a shell knows that
// it was interrupted, and a loop of commands ends too.
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include "duet_error.h"

#include <stdbool.h>

// Also watches scripts, which the library ends: where one of the calling thread is still
// there 2 s after its limit of time, the program ends with a line and exit status 1. A
// reader of stdout that goes away ends the program silently, by SIGPIPE.
void interrupt_watch(void);

bool interrupt_asked(void);
void interrupt_forget(void); // interrupt_asked is false again: a person goes on typing

// false with INTERRUPTED once Ctrl-C was pressed.
bool interrupt_check(duet_error *err);

// Whether signals reach the calling thread and the processes that it starts, which by
// default they do not.
void interrupt_pass(bool passes);

// Has a signal of this number mean the same. Before interrupt_watch.
void interrupt_hear(int number);

// Writes a byte to a file, as a socket, once a signal comes.
void interrupt_tell(int file);

// The effect of a signal from here on.
typedef enum interrupt_reaction {
    INTERRUPT_NOTED,       // the state at first: work asks between two steps
    INTERRUPT_AWAITED,     // the same, and the step under way is waited for, however long it takes
    INTERRUPT_INTERACTIVE, // ends the command that runs. If it must be waited for, a line says so,
                           // and a second Ctrl-C meanwhile ends the program
    INTERRUPT_ENDS,        // ends the program at once
    INTERRUPT_ENDS_SILENTLY, // the same without a line: the process that started this one sent the
                             // signal, and waits for it
} interrupt_reaction;

void interrupt_react(interrupt_reaction reaction);

// A line has said that the program was stopped.
void interrupt_told(void);

// Ends the program by the signal that asked for it.
_Noreturn void interrupt_end(void);

#endif
