// SPDX-License-Identifier: MIT
// The separating axis test (equation 3) of eight pairs at a time.
#ifndef BENCH_SAT_AVX2_H
#define BENCH_SAT_AVX2_H

#include "runtime/duet.h"

// A pose with its rotation worked out: one cache line.
typedef struct sat_box {
    float centre[3];
    float half_extents[3];
    float axes[3][3]; // axes[i]: the box's own axis i in the world
    uint32_t id;
} sat_box;

// Pairs found so far.
typedef struct sat_result {
    duet_pair *pairs; // space for 7 more than are written
    uint64_t n_pairs;
} sat_result;

// Tests the pairs first[i], second[i], which are places in boxes; poses are by
// id. SAT_SLACK entries from n on are valid places too: they are read, but not
// tested.
#define SAT_SLACK 48
void sat_avx2(const sat_box *boxes, const duet_pose *poses, const uint32_t *first,
              const uint32_t *second, uint32_t n, sat_result *result);

#endif
