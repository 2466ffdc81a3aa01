// SPDX-License-Identifier: MIT
// Meshes that tests put together, and how far places are from their triangles, in double.
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

// Puts a triangle with vertices of its own.
void shape_own_triangle(shape *s, double corners[3][3]);

// Puts the triangles of a grid of n x n heights about 0, as a ground of heights divides its cells.
void shape_grid(shape *s, uint32_t n, double spacing, double (*height)(double x, double y));

typedef struct vector {
    double x, y, z;
} vector;

vector vector_less(vector a, vector b);
double vector_dot(vector a, vector b);

// The distance from a point to a triangle, and to all of a mesh.
double triangle_distance(vector p, const vector t[3]);
double shape_distance(const shape *s, vector p);

#endif
