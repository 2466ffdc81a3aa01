// SPDX-License-Identifier: MIT
// The scene of the paper's measurements: unit cubes with random centres and
// rotations in a cube that holds one for every eight units of its volume.
#ifndef BENCH_PAPER_SCENE_H
#define BENCH_PAPER_SCENE_H

#include "runtime/duet.h"

// A rotated unit cube is at most sqrt(3) wide; a little more, so that rounding
// never makes it wider than its cell.
#define PAPER_CELL 1.7321f

float paper_world(uint32_t n); // edge of the cube [0, edge]^3: 200 for a million

// n poses from the seed, given back by free; NULL where memory runs out.
duet_pose *paper_poses(uint32_t n, uint64_t seed);

#endif
