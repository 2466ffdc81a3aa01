// SPDX-License-Identifier: MIT
// Meshes that tests put together.
#ifndef TESTS_SHAPE_H
#define TESTS_SHAPE_H

#include "runtime/duet.h"

enum { SHAPE_VERTICES = 30000, SHAPE_TRIANGLES = 30000 };

typedef struct shape {
    duet_mesh mesh; // that the arrays below have
    float vertices[3 * SHAPE_VERTICES];
    uint32_t triangles[3 * SHAPE_TRIANGLES];
} shape;

// An empty one, which the caller frees.
shape *shape_new(void);

// Puts a vertex, and returns its place; a triangle of three, and two of four.
uint32_t shape_vertex(shape *s, double x, double y, double z);
void shape_triangle(shape *s, uint32_t a, uint32_t b, uint32_t c);
void shape_quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

// Puts the triangles of a grid of n x n heights about 0, as a ground of heights divides its cells.
void shape_grid(shape *s, uint32_t n, double spacing, double (*height)(double x, double y));

#endif
