// SPDX-License-Identifier: MIT
// Lanes of flush tiles along x, and bodies that glide over them.
#ifndef TESTS_LANES_H
#define TESTS_LANES_H

#include "support/mover.h"

#include "base/rng.h"

enum { TILES = 60, BALL = 0, ROLLING, CAPSULE_ALONG, CAPSULE_ACROSS, ROUNDED_BOX, SHAPES };

#define LANES_SLOP 0.005

// What a lane is paved with: unit tiles whose tops lie at its height, in 3D three side by side; or
// one box of that size.
typedef struct {
    double gap, uneven; // most between tiles, and below the lane's height
    bool one_box;
} paving;

// Gravity and contact response, and no objects.
mover *lanes_new(uint32_t dims);

uint32_t lanes_add_fixed(mover *m, const double at[3], const double half[3]);

// Lanes lie side by side, in 2D above each other, this far from the first.
double lanes_place(int lane);

void lanes_add(mover *m, int lane, const paving *p, rng *r);

// Puts a body at the begin of a lane; returns its place.
uint32_t lanes_add_glider(mover *m, int shape, int lane, double speed);

// Turns the whole scene, and gravity, about the origin.
void lanes_turn(mover *m, double x, double y, double z, double angle);

#endif
