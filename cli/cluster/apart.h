// SPDX-License-Identifier: MIT
// What it costs a rank that others of its machine work beside it: each by itself, one of them
// first, then two, four, and so on up to all. Those that wait for their turn sleep.
#ifndef CLI_CLUSTER_APART_H
#define CLI_CLUSTER_APART_H

#include "cluster/ranks.h"

enum { APART_MOST = 32 };

typedef struct apart_times {
    int n;                 // of the rows below
    int ranks[APART_MOST]; // at work, the first so many; ascending, all of them at last
    double ms[APART_MOST]; // a step, from all of them together to the slowest: the median
    double *all_ms;        // [repeat] the steps of the last row, ascending; the caller's
} apart_times;

// One step of this rank's own, and how long it took.
typedef bool apart_step(void *context, double *ms, duet_error *err);

// After a step of each, one after the other, so that kernels are built once. Collective; all has
// to be of one machine. What one rank cannot do fails on all.
bool apart_measure(apart_times *t, ranks *all, uint64_t repeat, apart_step *step, void *context,
                   duet_error *err);

// The first row in which that rank was at work.
int apart_first_of(const apart_times *t, int rank);

#endif
