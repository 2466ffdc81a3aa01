// SPDX-License-Identifier: MIT
// What a hundred thousand substeps of free tumbling take, box by box: sums over
// boxes would hide errors that go either way.
#include "support/figure.h"
#include "support/mover.h"
#include "support/test.h"

enum { BOXES = 200, STEPS = 2000, SUBSTEPS = 50 };

typedef struct kept {
    double momentum, energy;
} kept;

static void to_body(const double q[4], const double v[3], double out[3])
{
    double x = -q[0], y = -q[1], z = -q[2], w = q[3];
    double norm = x * x + y * y + z * z + w * w;
    double t[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
    out[0] = v[0] + (w * t[0] + (y * t[2] - z * t[1])) / norm;
    out[1] = v[1] + (w * t[1] + (z * t[0] - x * t[2])) / norm;
    out[2] = v[2] + (w * t[2] + (x * t[1] - y * t[0])) / norm;
}

// Belongs to a box of mass 1, with the inverse inertia that its motion has, in float.
static kept kept_of(const mover *m, uint32_t id)
{
    const float *h = m->poses[id].half_extents;
    double spin[3];
    kept sum = {0, 0};
    to_body(m->states[id].rotation, m->states[id].angular_velocity, spin);
    for (int k = 0; k < 3; ++k) {
        double a = h[(k + 1) % 3], b = h[(k + 2) % 3];
        double inertia = 1 / (double)(float)(1 / ((a * a + b * b) / 3));
        sum.momentum += inertia * inertia * spin[k] * spin[k];
        sum.energy += 0.5 * inertia * spin[k] * spin[k];
    }
    return (kept){sqrt(sum.momentum), sum.energy};
}

static mover *tumbling(bool doubles, double spin)
{
    rng r = rng_seed(test_seed());
    mover *m = mover_new(3);
    m->def.doubles = doubles;
    m->def.dt = 0.01;
    m->def.substeps = SUBSTEPS;
    for (int i = 0; i < BOXES; ++i) {
        uint32_t id = mover_add(m, 10 * i, 0, 0, rng_between(&r, 0.1, 0.5),
                                rng_between(&r, 0.1, 0.5), rng_between(&r, 0.1, 0.5));
        mover_turn(m, id, rng_normal(&r), rng_normal(&r), rng_normal(&r), rng_between(&r, 0, 3));
        for (int k = 0; k < 3; ++k)
            m->bodies[id].angular_velocity[k] = (float)(spin * rng_normal(&r));
    }
    return m;
}

typedef struct drift {
    kept mean, worst;
} drift;

static drift drift_of(bool doubles, double spin)
{
    static kept before[BOXES];
    mover *m = tumbling(doubles, spin);
    drift d = {{0, 0}, {0, 0}};
    mover_run(m, 0);
    for (uint32_t i = 0; i < BOXES; ++i)
        before[i] = kept_of(m, i);
    mover_run(m, STEPS);
    for (uint32_t i = 0; i < BOXES; ++i) {
        kept after = kept_of(m, i);
        double momentum = after.momentum / before[i].momentum - 1;
        double energy = after.energy / before[i].energy - 1;
        d.mean.momentum += momentum / BOXES;
        d.mean.energy += energy / BOXES;
        d.worst.momentum = fmax(d.worst.momentum, fabs(momentum));
        d.worst.energy = fmax(d.worst.energy, fabs(energy));
    }
    print_message("mean %.1e of momentum, %.1e of energy; at most %.1e and %.1e\n", d.mean.momentum,
                  d.mean.energy, d.worst.momentum, d.worst.energy);
    return d;
}

static void assert_worst(drift d, const char *says)
{
    double worst[2];
    figures("notes/effects.md", says, 2, worst);
    assert_true(d.worst.momentum < worst[0]);
    assert_true(d.worst.energy < worst[1]);
}

TEST(tumbling_in_float_keeps_momentum_and_energy)
{
    drift d = drift_of(false, 5);
    assert_worst(d, "in float none loses or gains more than # of its momentum and # of its energy");
    double mean[2];
    figures("notes/effects.md", "their mean less than # and #", 2, mean);
    assert_close(d.mean.momentum, 0, mean[0]);
    assert_close(d.mean.energy, 0, mean[1]);
    assert_worst(drift_of(false, 0.5), "ten times as slow, # and #");
}

TEST(tumbling_in_double_keeps_its_momentum)
{
    assert_worst(drift_of(true, 5), "in double # of the momentum and # of the energy");
}

// A box of each shape in turn, its sides up to a third more or less.
static mover *thin_boxes(rng *r, uint32_t substeps)
{
    static const double shapes[][3] = {
        {1, 0.01, 0.01}, {1, 0.02, 0.02}, {1, 1, 0.01}, {1, 0.3, 0.02}, {1, 0.6, 0.3}};
    const double most_spin = 60;
    mover *m = mover_new(3);
    m->def.substeps = substeps;
    for (int i = 0; i < BOXES; ++i) {
        const double *h = shapes[i % 5];
        double axis[3], length = 0, spin = most_spin * rng_unit(r);
        uint32_t id = mover_add(m, 10 * i, 0, 0, h[0] * rng_between(r, 0.7, 1.3),
                                h[1] * rng_between(r, 0.7, 1.3), h[2] * rng_between(r, 0.7, 1.3));
        for (int k = 0; k < 3; ++k)
            axis[k] = rng_normal(r);
        length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        for (int k = 0; k < 3; ++k)
            m->bodies[id].angular_velocity[k] = (float)(spin * axis[k] / length);
    }
    return m;
}

// A free body keeps both for ever, however far it turns in a step.
TEST(thin_boxes_that_turn_far_keep_their_energy)
{
    static kept before[BOXES];
    rng r = rng_seed(test_seed());
    print_message("DUET_TEST_SEED=%llu\n", (unsigned long long)test_seed());
    double part = figure("notes/effects.md", "no box may gain or lose more than # %") / 100;
    for (uint32_t substeps = 1; substeps <= 4; substeps += 3) {
        kept worst = {0, 0};
        mover *m = thin_boxes(&r, substeps);
        mover_run(m, 0);
        for (uint32_t i = 0; i < BOXES; ++i)
            before[i] = kept_of(m, i);
        for (int step = 0; step < 600; ++step) {
            mover_run(m, 1);
            for (uint32_t i = 0; i < BOXES; ++i) {
                kept now = kept_of(m, i);
                worst.energy = fmax(worst.energy, fabs(now.energy / before[i].energy - 1));
                worst.momentum = fmax(worst.momentum, fabs(now.momentum / before[i].momentum - 1));
            }
        }
        print_message("%u substeps: at most %.1e of momentum, %.1e of energy\n", substeps,
                      worst.momentum, worst.energy);
        assert_true(worst.energy < part);
        assert_true(worst.momentum < 1e-3);
    }
}
