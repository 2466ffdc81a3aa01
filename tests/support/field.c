// SPDX-License-Identifier: MIT
#include "support/field.h"
#include "support/test.h"

field *field_new(uint32_t n, double spacing, double (*height)(double x, double y))
{
    field *f = test_alloc(sizeof *f);
    double half = (n - 1) * spacing / 2;
    assert_true(n <= FIELD_MOST);
    f->triangles = shape_new();
    shape_grid(f->triangles, n, spacing, height);
    for (uint32_t i = 0; i < n * n; ++i)
        f->values[i] = f->triangles->vertices[3 * i + 2];
    f->heights = (duet_heights){.nx = n,
                                .ny = n,
                                .origin = {-half, -half, 0},
                                .spacing = {spacing, spacing},
                                .heights = f->values};
    return f;
}

double field_above(const field *f, double x, double y, double z)
{
    const duet_heights *h = &f->heights;
    double u = (x - h->origin[0]) / h->spacing[0], v = (y - h->origin[1]) / h->spacing[1];
    if (u < 0 || v < 0 || u >= h->nx - 1 || v >= h->ny - 1)
        return INFINITY;
    uint32_t i = (uint32_t)u, j = (uint32_t)v;
    const float *at = h->heights + j * h->nx + i;
    double a = (double)at[0], b = (double)at[1], c = (double)at[h->nx], d = (double)at[h->nx + 1];
    u -= i;
    v -= j;
    return z - (u >= v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c));
}

void field_assert_none_falls_through(const field *f, mover *m)
{
    rng r = rng_seed(test_seed());
    for (int k = 0; k < 120; ++k)
        ground_add_thrown(m, &r, k % GROUND_KINDS);
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 5);
        mover_assert_finite(m);
        for (uint32_t id = 0; id < m->n; ++id) {
            const double *c = m->states[id].centre;
            double above = field_above(f, c[0], c[1], c[2]);
            if (!(above > -0.05)) // it may be pushed so deep by what falls on it
                fail_msg("kind %u is %g below the ground after %d steps", id % GROUND_KINDS, -above,
                         5 * (i + 1));
        }
    }
}

// Contacts end by a slack before the margin.
uint32_t field_assert_ball_depths(const shape *s, mover *m)
{
    double *least = test_alloc(MOVER_MOST * sizeof *least);
    uint32_t touching = 0;
    m->def.wants = DUET_EFFECT_CONTACT | DUET_EFFECT_RADIUS;
    m->def.slop = 0.02;
    ground_least_separations(m, least);
    for (uint32_t id = 0; id < m->n; ++id) {
        const float *c = m->poses[id].centre;
        const vector at = {(double)c[0], (double)c[1], (double)c[2]};
        double expected = shape_distance(s, at) - (double)m->bodies[id].radius;
        touching += least[id] < INFINITY;
        if (expected < 0.0799 || least[id] < INFINITY)
            if (!(fabs(least[id] - expected) < 0x1p-16))
                fail_msg("ball %u: %g apart, not %g", id, least[id], expected);
    }
    return touching;
}
