// SPDX-License-Identifier: MIT
// Loops over many objects, by all threads that a rank has (runtime/opencl/thread_pool.h).
#ifndef CLUSTER_PARALLEL_H
#define CLUSTER_PARALLEL_H

#include "duet_error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PARALLEL_MOST = 64 }; // parts of a loop

typedef struct parallel {
    struct thread_pool *team; // besides the caller's thread; NULL: that alone
    uint32_t n;               // threads with that
    bool is_oversubscribed;   // they are more than there are processors for them
} parallel;

// A thread for each whole one of that many processors, and so many at least.
bool parallel_begin(parallel *p, double processors, uint32_t least, duet_error *err);
void parallel_end(parallel *p);

// Whether they look for loops rather than sleep: only if nothing else needs the processors, and
// never if they are oversubscribed.
void parallel_stay_awake(parallel *p, bool awake);

// Calls body for each part [first, end) of [0, n), several at the same time. Parts are
// numbered from 0 in ascending order. Returns how many there were, at most PARALLEL_MOST.
typedef void parallel_body(void *context, uint32_t part, uint64_t first, uint64_t end);
uint32_t parallel_each(parallel *p, uint64_t n, parallel_body *body, void *context);

// The same of at most PARALLEL_MOST things, each of which is long work and a part of its own. p
// may be NULL: then one after the other.
void parallel_jobs(parallel *p, uint32_t n, parallel_body *body, void *context);

// Copies n rows of so many bytes to memory that they do not lie in.
void parallel_copy(parallel *p, void *to, const void *from, uint64_t n, size_t bytes);

#endif
