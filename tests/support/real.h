// SPDX-License-Identifier: MIT
// Vectors, triangles and boxes in long double: truths that no code of the library has a part in.
#ifndef TESTS_REAL_H
#define TESTS_REAL_H

#include "runtime/duet.h"

typedef long double real;

void real_less(real out[3], const real a[3], const real b[3]);
void real_cross(real out[3], const real u[3], const real v[3]);
real real_dot(const real u[3], const real v[3]);

// The axes of what a rotation turns, which may have any length.
void real_axes(real axis[3][3], const float rotation[4]);

typedef struct triangle {
    real at[3][3];
} triangle;

// When a ray passes a triangle; INFINITY: it never does.
real triangle_pass(const triangle *t, const duet_ray *ray);

// Cuts off a convex polygon of n corners what has inside below 0, a number of each corner that is
// linear in places. Returns how many corners are left: one more at most.
int polygon_clip(real at[12][3], int n, const real inside[12]);

typedef struct block {
    real centre[3], axis[3][3], half[3];
} block;

block block_of(const duet_pose *pose);
void block_corner(const block *b, int which, real at[3]);

// The box of a sweep at a time.
block block_moved(const duet_sweep *sweep, real t);

#endif
