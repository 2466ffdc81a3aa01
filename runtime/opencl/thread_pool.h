// SPDX-License-Identifier: MIT
// Threads that wait for one job at a time, which each of them does.
#ifndef RUNTIME_THREAD_POOL_H
#define RUNTIME_THREAD_POOL_H

#include "runtime/duet.h"

typedef struct thread_pool thread_pool;

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err);
void thread_pool_close(thread_pool *c); // waits for the job under way

// Starts job(arg) in every thread; the last job must have been waited for.
void thread_pool_start(thread_pool *c, void (*job)(void *), void *arg);
void thread_pool_wait(thread_pool *c);

// job(a) in the pool's only thread and job(b) in the caller's, at the same time. NULL: that one
// has nothing to do; with one of them the pool is not needed.
void thread_pool_run_both(thread_pool *c, void (*job)(void *), void *a, void *b);

#endif
