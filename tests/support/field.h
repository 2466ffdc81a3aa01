// SPDX-License-Identifier: MIT
// A ground of n x n heights about 0, and the same as a mesh.
#ifndef TESTS_FIELD_H
#define TESTS_FIELD_H

#include "support/ground.h"
#include "support/shape.h"

enum { FIELD_MOST = 97 };

typedef struct field {
    duet_heights heights;
    float values[FIELD_MOST * FIELD_MOST];
    shape *triangles;
} field;

field *field_new(uint32_t n, double spacing, double (*height)(double x, double y));

// How high a point is above the ground under it; INFINITY beside the grid.
double field_above(const field *f, double x, double y, double z);

// Lets bodies of all kinds that are thrown down fall on a mover's ground, the field; fails if a
// centre comes to lie below it.
void field_assert_none_falls_through(const field *f, mover *m);

// Fails unless the contacts of a mover's balls, all outside of its ground, are as deep as the
// ground's triangles say. Returns how many touch.
uint32_t field_assert_ball_depths(const shape *s, mover *m);

#endif
