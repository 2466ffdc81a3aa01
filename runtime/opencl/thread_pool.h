// SPDX-License-Identifier: MIT
// Threads that wait for a loop, which they and the caller's thread do together.
//
// A loop is pieces of [0, n). Each thread takes the next piece until none is left, so that the
// caller never waits for a thread that is late: only for those that are inside a piece. One loop
// is under way at a time, and beside it at most one call.
#ifndef RUNTIME_THREAD_POOL_H
#define RUNTIME_THREAD_POOL_H

#include "runtime/duet.h"

typedef struct thread_pool thread_pool;

// Threads that this machine has to spare besides the two that drive the devices: 1 to `most`.
uint32_t thread_pool_spare(uint32_t most);

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err);
void thread_pool_close(thread_pool *c); // NULL allowed; waits for what is under way

// Has the threads look for work for a while before they sleep, since waking them takes about as
// long as a loop. Only if nothing else needs the processors.
void thread_pool_stay_awake(thread_pool *c, bool awake);

// Calls some(arg, first, last) for pieces of [0, n), several at the same time. NULL: the caller's
// thread does it alone.
typedef void thread_pool_some(void *arg, uint64_t first, uint64_t last);
void thread_pool_share(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n,
                       uint64_t piece);

// The same for pieces of one, without the caller's thread until it waits; it then takes what no
// thread has begun. NULL: it waits for nothing.
void thread_pool_start(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n);
void thread_pool_wait(thread_pool *c);

typedef void thread_pool_job(void *arg);

// job(a) in the pool's only thread and job(b) in the caller's, at the same time. NULL: that one
// has nothing to do; with one of them the pool is not needed.
void thread_pool_run_both(thread_pool *c, thread_pool_job *job, void *a, void *b);

// Makes one long call in a thread of the pool, beside loops of the others. The end makes it itself
// if no thread has begun it.
void thread_pool_begin_call(thread_pool *c, thread_pool_job *call, void *arg);
void thread_pool_end_call(thread_pool *c);

#endif
