// SPDX-License-Identifier: MIT
// The limits of an untrusted script: time, and memory of the host beside its own state's.
//
// A budget is the calling thread's while the script runs. Work of the host that a script can make
// long asks budget_check now and then, and budget_space before it takes much memory. If no script
// runs, both return true at once.
#ifndef BASE_BUDGET_H
#define BASE_BUDGET_H

#include "base/error.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct budget {
    uint64_t deadline_ns;         // steady clock; UINT64_MAX: none
    double seconds;               // the time limit, for messages
    size_t host_bytes;            // most memory of the process; SIZE_MAX: as much as there is
    void (*reclaim)(void *owner); // releases what the script no longer uses; NULL: nothing
    void *owner;
    const struct budget *outer;
} budget;

// Callbacks by which a program follows and stops scripts and other long work of one thread.
typedef struct budget_watch {
    bool (*stopped)(void);        // asked now and then: true ends the script
    _Atomic uint64_t deadline_ns; // deadline of the running script; 0: none runs
    void (*told)(void *listener, uint64_t done, uint64_t total);
    void *listener;
} budget_watch;

void budget_set_watch(budget_watch *watch);

// Reports the progress of the thread's work to `told`, until NULL is set; total is 0 if it is not
// known. Meanwhile `stopped` ends work outside of scripts too.
void budget_listen(void (*told)(void *listener, uint64_t done, uint64_t total), void *listener);

// Makes b the thread's. An inner budget ends no later and has no more memory than the one around
// it.
void budget_enter(budget *b);
void budget_leave(budget *b);

// Reports progress of long work of the host.
void budget_tell(uint64_t done, uint64_t total);

// Returns false with INTERRUPTED if the program was told to stop, with BAD_INPUT if the time is
// over.
bool budget_check(duet_error *err);

// Returns false with INTERRUPTED if the program was told to stop, even if no script runs: for work
// that takes seconds without a result.
bool budget_check_stop(duet_error *err);

// Says whether the host may take `bytes` more; false with NO_MEMORY.
bool budget_space(size_t bytes, duet_error *err);

// "20 MiB", or "100 KiB" if it is no whole number of MiB.
typedef struct budget_words {
    char chars[32];
} budget_words;

budget_words budget_memory(size_t bytes);

// Counts memory of the host as long as it is held, on any thread: rows of objects, buffers, and
// what drivers keep of OpenCL's objects. They are most of what a script can make much of.
void budget_hold(size_t bytes);
void budget_release(size_t bytes);

#endif
