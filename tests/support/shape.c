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

void shape_own_triangle(shape *s, double at[3][3])
{
    uint32_t own[3];
    for (int i = 0; i < 3; ++i)
        own[i] = shape_vertex(s, at[i][0], at[i][1], at[i][2]);
    shape_triangle(s, own[0], own[1], own[2]);
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

// ---------------------------------------------------------------- triangles, in double

vector vector_less(vector a, vector b)
{
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

double vector_dot(vector a, vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The distance from a point to a segment, squared.
static double square_to_edge(vector p, vector a, vector b)
{
    vector along = vector_less(b, a), way = vector_less(p, a);
    double t = fmax(0, fmin(1, vector_dot(way, along) / vector_dot(along, along)));
    vector apart = {way.x - t * along.x, way.y - t * along.y, way.z - t * along.z};
    return vector_dot(apart, apart);
}

// By the triangle's plane if the foot lies in it, else by its edges.
double triangle_distance(vector p, const vector t[3])
{
    vector u = vector_less(t[1], t[0]), v = vector_less(t[2], t[0]), w = vector_less(p, t[0]);
    double uu = vector_dot(u, u), uv = vector_dot(u, v), vv = vector_dot(v, v);
    double wu = vector_dot(w, u), wv = vector_dot(w, v), det = uu * vv - uv * uv;
    double a = (vv * wu - uv * wv) / det, b = (uu * wv - uv * wu) / det;
    if (a >= 0 && b >= 0 && a + b <= 1) {
        vector apart = {w.x - a * u.x - b * v.x, w.y - a * u.y - b * v.y, w.z - a * u.z - b * v.z};
        return sqrt(vector_dot(apart, apart));
    }
    return sqrt(fmin(square_to_edge(p, t[0], t[1]),
                     fmin(square_to_edge(p, t[1], t[2]), square_to_edge(p, t[2], t[0]))));
}

static vector corner_at(const shape *s, uint32_t triangle, int k)
{
    const float *v = s->vertices + 3 * s->triangles[3 * triangle + k];
    const double *o = s->mesh.origin;
    return (vector){o[0] + (double)v[0], o[1] + (double)v[1], o[2] + (double)v[2]};
}

double shape_distance(const shape *s, vector p)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        const vector t[3] = {corner_at(s, i, 0), corner_at(s, i, 1), corner_at(s, i, 2)};
        least = fmin(least, triangle_distance(p, t));
    }
    return least;
}
