// SPDX-License-Identifier: MIT
// Threads that wait for one job at a time, which each of them does.
#ifndef RUNTIME_THREAD_POOL_H
#define RUNTIME_THREAD_POOL_H

#include "runtime/duet.h"

typedef struct thread_pool thread_pool;

// Threads that this machine has to spare besides the two that drive the devices: 1 to `most`.
uint32_t thread_pool_spare(uint32_t most);

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err);
void thread_pool_close(thread_pool *c); // waits for the job under way

// Starts job(arg) in every thread; the last job must have been waited for.
void thread_pool_start(thread_pool *c, void (*job)(void *), void *arg);
void thread_pool_wait(thread_pool *c); // NULL: for nothing

// job(a) in the pool's only thread and job(b) in the caller's, at the same time. NULL: that one
// has nothing to do; with one of them the pool is not needed.
void thread_pool_run_both(thread_pool *c, void (*job)(void *), void *a, void *b);

// Work on n things: each of the threads and the caller's takes `piece` of them until none is left.
// NULL: the caller's does it alone.
typedef void thread_pool_some(void *arg, uint64_t first, uint64_t last);
void thread_pool_share(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n,
                       uint64_t piece);

#endif
