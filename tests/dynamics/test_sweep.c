// SPDX-License-Identifier: MIT
// What moves and turns far in a step: rods that sweep, bullets out of line. They neither
// pass what is in their way nor leave it with more energy than they came with.
#include "support/figure.h"
#include "support/mover.h"
#include "support/test.h"

// ---------------------------------------------------------------- what became of it

// How far a body reaches along x.
static double reach_of(const mover *m, uint32_t id)
{
    const double *q = m->states[id].rotation;
    const float *h = m->poses[id].half_extents;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double reach =
        fabs(1 - 2 * (y * y + z * z)) * (double)h[0] + fabs(2 * (x * y - w * z)) * (double)h[1];
    return m->def.dims == 2 ? reach : reach + fabs(2 * (x * z + w * y)) * (double)h[2];
}

static double kinetic(mover *m)
{
    duet_energy e = mover_energy(m);
    return e.kinetic + e.turning;
}

typedef struct outcome {
    double furthest, deepest; // that its centre came along x, and a corner beyond the face
    double most, left;        // kinetic energy, of what there was at first
} outcome;

static outcome watch(mover *m, uint32_t id, double face, int steps)
{
    outcome o = {.furthest = -1e30, .deepest = -1e30};
    double before = kinetic(m);
    for (int i = 0; i < steps; ++i) {
        mover_run(m, 1);
        mover_assert_finite(m);
        double x = m->states[id].centre[0];
        o.furthest = fmax(o.furthest, x);
        o.deepest = fmax(o.deepest, x + reach_of(m, id) - face);
        o.left = kinetic(m) / before;
        o.most = fmax(o.most, o.left);
    }
    return o;
}

// ---------------------------------------------------------------- rods

static const double rates[] = {20, 60, 200, 1000}; // radians a second: up to 17 a step

enum { RATES = sizeof rates / sizeof rates[0] };

static uint32_t add_rod(mover *m, double angle, double rate, double restitution)
{
    uint32_t rod = mover_add(m, 0, 0, 0, 0.02, 1, 0.02);
    mover_turn(m, rod, 0, 0, 1, angle);
    m->bodies[rod].angular_velocity[2] = (float)rate;
    m->bodies[rod].restitution = (float)restitution;
    m->bodies[rod].friction = 0.5f;
    return rod;
}

// The energy that the free flight of a rod that tumbles gains by itself (test_tumbling).
static double most_energy(void)
{
    double f[1];
    figures("effects.md", "never have more than # % more energy than they came with", 1, f);
    return 1.0 + f[0] / 100;
}

TEST(a_rod_that_sweeps_stops_at_a_thin_wall)
{
    rng r = rng_seed(test_seed());
    double most = most_energy();
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int i = 0; i < 2 * RATES; ++i) {
            mover *m = mover_new(dims);
            mover_add_fixed(m, 0.505, 0, 0, 0.005, 5, 5);
            double angle = rng_between(&r, -0.45, 0.45), bounce = i % 2 ? 0.9 : 0.0;
            uint32_t rod = add_rod(m, angle, rates[i / 2], bounce);
            outcome o = watch(m, rod, 0.5, 20);
            assert_true(duet_motion_get_effects(m->motion) & DUET_EFFECT_CONTINUOUS);
            if (!(o.deepest < 0.005 && o.most < most && o.left < 0.95))
                fail_msg(
                    "%uD, %g rad/s from %g, restitution %g: %g deep, %g of its energy, %g left",
                    dims, rates[i / 2], angle, bounce, o.deepest, o.most, o.left);
        }
}

// The post stands still, or is as heavy as the rod and is struck away.
TEST(a_rod_that_sweeps_past_a_post_strikes_it)
{
    rng r = rng_seed(test_seed());
    double most = most_energy();
    for (int i = 0; i < 4 * RATES; ++i) {
        mover *m = mover_new(3);
        double rate = rates[i / 4], angle = rng_between(&r, -1.2, 1.2),
               tilt = rng_between(&r, -0.1, 0.1);
        uint32_t post = mover_add(m, 0.7, 0, 0, 0.03, 0.03, 2);
        m->bodies[post].mass = i % 2 ? 1.0f : 0.0f;
        uint32_t rod = add_rod(m, angle, rate, i / 2 % 2 ? 0.9 : 0.0);
        m->bodies[rod].angular_velocity[0] = (float)(tilt * rate);
        outcome o = watch(m, rod, 0.7, 25);
        if (!(o.most < most && o.left < 0.97))
            fail_msg("%d: %g rad/s from %g, tilted by %g: %g of its energy, %g left", i, rate,
                     angle, tilt, o.most, o.left);
    }
}

// ---------------------------------------------------------------- bullets

TEST(a_bullet_out_of_line_does_not_pass_a_wall)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 16; ++i) {
        mover *m = mover_new(3);
        mover_add_fixed(m, 10, 0, 0, 0.05, 2000, 2000);
        uint32_t cube = mover_add_cube(m, 0.013, 0, 0, 0.1);
        double x = rng_normal(&r), y = rng_normal(&r), z = rng_normal(&r);
        double angle = rng_between(&r, 0, 3.1);
        mover_turn(m, cube, x, y, z, angle);
        m->bodies[cube].velocity[0] = i % 2 ? 200.0f : 2000.0f;
        m->bodies[cube].friction = 0.5f;
        outcome o = watch(m, cube, 9.95, 20);
        if (!(o.furthest < 10.0 && o.most <= 1.0 && m->states[cube].centre[0] < 9.95))
            fail_msg("%g m/s, turned by %g about %g %g %g: comes to %g, %g of its energy",
                     (double)m->bodies[cube].velocity[0], angle, x, y, z, o.furthest, o.most);
    }
}
