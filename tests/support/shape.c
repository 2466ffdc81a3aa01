// SPDX-License-Identifier: MIT
#include "support/shape.h"
#include "support/test.h"

shape *shape_new(void)
{
    shape *s = test_alloc(sizeof *s);
    s->mesh = (duet_mesh){.vertices = s->vertices, .triangles = s->triangles};
    return s;
}

uint32_t shape_vertex(shape *s, double x, double y, double z)
{
    assert_true(s->mesh.n_vertices < SHAPE_VERTICES);
    float *at = s->vertices + 3 * s->mesh.n_vertices;
    at[0] = (float)x;
    at[1] = (float)y;
    at[2] = (float)z;
    return s->mesh.n_vertices++;
}

void shape_triangle(shape *s, uint32_t a, uint32_t b, uint32_t c)
{
    assert_true(s->mesh.n_triangles < SHAPE_TRIANGLES);
    uint32_t *t = s->triangles + 3 * s->mesh.n_triangles++;
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

void shape_quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    shape_triangle(s, a, b, c);
    shape_triangle(s, a, c, d);
}

void shape_grid(shape *s, uint32_t n, double spacing, double (*height)(double x, double y))
{
    double half = (n - 1) * spacing / 2;
    uint32_t first = s->mesh.n_vertices;
    for (uint32_t i = 0; i < n * n; ++i) {
        double x = i % n * spacing - half, y = i / n * spacing - half;
        shape_vertex(s, x, y, height(x, y));
    }
    for (uint32_t j = 0; j + 1 < n; ++j)
        for (uint32_t i = 0; i + 1 < n; ++i) {
            uint32_t a = first + j * n + i;
            shape_quad(s, a, a + 1, a + n + 1, a + n);
        }
}
