// SPDX-License-Identifier: MIT
// The limit to chase: what Duet does in a step, as a plain C program for the
// paper scene with AVX2 and two threads, without OpenCL.
#ifndef BENCH_LIMIT_AVX2_H
#define BENCH_LIMIT_AVX2_H

#include "runtime/duet.h"

typedef struct limit limit;

// The time of a run by stages, in milliseconds. candidates and narrow are one
// stage: each is its part of that stage's time.
typedef struct limit_times {
    double count, scan, place, reorder, candidates, narrow;
    double total;
    double processors; // CPU time over wall time
} limit_times;

// Space for n poses in the cube [0, world)^3, none wider than the cell edge.
// Poses further out are found too. NULL where memory runs out.
limit *limit_open(uint32_t n, float world, float cell, uint32_t threads);
void limit_close(limit *l);

// Finds all pairs among the n poses; false where there is no space for them.
bool limit_run(limit *l, const duet_pose *poses, limit_times *times);

// The pairs that one thread found; they last until the next run.
duet_span limit_span(const limit *l, uint32_t thread);

#endif
