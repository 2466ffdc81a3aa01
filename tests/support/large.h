// SPDX-License-Identifier: MIT
// Boxes in origin cells, and worlds that take them.
#ifndef TESTS_LARGE_H
#define TESTS_LARGE_H

#include "base/rng.h"
#include "runtime/duet.h"

#define LARGE_EDGE 0.125f // edge of the cells: boxes reach over many

enum { LARGE_MOST = 1000 };

extern duet_large_pose large_poses[LARGE_MOST];

duet_world_def large_def(uint32_t dims, bool rotated); // on the tests' devices

// Makes large_poses from .. from + n - 1: boxes about a place, of sizes up to `most` times the
// least.
void scatter_large(uint32_t from, uint32_t n, const double at[3], double side, double most,
                   bool rotated, rng *r);

#endif
