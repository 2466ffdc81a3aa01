// SPDX-License-Identifier: MIT
// Times that each device took for its part of plans, so that brute force need not launch a plan of
// which one part alone was seen to take too long.
#ifndef BENCH_PART_TIMES_H
#define BENCH_PART_TIMES_H

#include "tuner/measure.h"

enum { PART_TIMES = 1024 }; // of a device

// The least of a part's launches, at a share by a kernel, without what other programs took of them.
typedef struct part_time {
    uint32_t share;
    char variant[DUET_VARIANT];
    int64_t ns;
} part_time;

typedef struct part_times {
    part_time of[2][PART_TIMES];
    uint32_t n[2];
    int64_t least_ns; // a launch's, of any plan, with what other programs took of it
    uint32_t passed_over;
} part_times;

// Whether the plan may be the quickest: it shares nothing, or no part of it took 1.3 times as long
// as the quickest plan, by the same kernel at the same share. Counts those that may not.
bool part_times_allow(part_times *p, const duet_plan *plan);

void part_times_add(part_times *p, const duet_plan *plan, const measure_launch *launch);

#endif
