// SPDX-License-Identifier: MIT
// What a script that nobody vouches for may still take: time, and memory of
// the host beside its own state's.
//
// A budget is the calling thread's while the script runs. Work of the host that
// a script can make long asks budget_check now and then, and budget_space before
// it takes much memory. Both are true at once if no script runs.
#ifndef BASE_BUDGET_H
#define BASE_BUDGET_H

#include "base/error.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct budget {
    uint64_t deadline_ns;         // steady clock; UINT64_MAX: none
    double seconds;               // the time as messages name it
    size_t host_bytes;            // that the process may hold; SIZE_MAX: as much as there is
    void (*reclaim)(void *owner); // releases what the script no longer uses; NULL: nothing
    void *owner;
    const struct budget *outer;
} budget;

// How a program hears of scripts and other long work, and stops them; of the thread that
// sets it.
typedef struct budget_watch {
    bool (*stopped)(void);        // asked now and then: true ends the script
    _Atomic uint64_t deadline_ns; // the running script's; 0: none runs
    void (*told)(void *listener, uint64_t done, uint64_t total);
    void *listener;
} budget_watch;

// Returns the one that the thread had. NULL: nothing stops its work.
budget_watch *budget_set_watch(budget_watch *watch);

// Has `told` hear how far the work of the thread is, until NULL is given; total is 0 if
// it is not known. While it does, `stopped` ends work outside of scripts too.
void budget_listen(void (*told)(void *listener, uint64_t done, uint64_t total), void *listener);

// Makes b the thread's. A budget inside another ends no later and has no more
// memory than that one.
void budget_enter(budget *b);
void budget_leave(budget *b);

// Long work of the host says how far it is.
void budget_tell(uint64_t done, uint64_t total);

// false with INTERRUPTED if the thread's program was told to stop, with
// BAD_INPUT if the time is over.
bool budget_check(duet_error *err);

// false with INTERRUPTED if the thread's program was told to stop, also if no script
// runs: for what takes seconds and has brought nothing yet.
bool budget_check_stop(duet_error *err);

// Whether the host may take so many more bytes; false with NO_MEMORY.
bool budget_space(size_t bytes, duet_error *err);

// "20 MiB", or "100 KiB" where it is no whole number of those.
typedef struct budget_words {
    char chars[32];
} budget_words;

budget_words budget_memory(size_t bytes);

// Counts memory of the host as long as it is held, on any thread: rows of objects, buffers, and
// what drivers keep of OpenCL's objects. They are most of what a script can make much of.
void budget_hold(size_t bytes);
void budget_release(size_t bytes);

#endif
