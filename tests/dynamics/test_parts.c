// SPDX-License-Identifier: MIT
// What must not depend on the order of bodies, on which device finds what, or on the first body.
#include "support/mover.h"
#include "support/test.h"

#include "runtime/dynamics/motion.h"

enum { OBJECTS = 300 };

static void swap_bodies(mover *m, uint32_t i, uint32_t k)
{
    duet_pose pose = m->poses[i];
    duet_body body = m->bodies[i];
    m->poses[i] = m->poses[k];
    m->bodies[i] = m->bodies[k];
    m->poses[k] = pose;
    m->bodies[k] = body;
}

static void shuffle(mover *m, rng *r)
{
    mover_restart(m);
    for (uint32_t i = m->n; i > 1; --i)
        swap_bodies(m, i - 1, rng_below(r, i));
}

// Bodies of sizes over 32 octaves, far from each other.
static mover *make_flight(rng *r)
{
    mover *m = mover_new(3);
    m->def.gravity[2] = -9.81;
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        double size = exp2(rng_between(r, -26, 6));
        uint32_t id = mover_add(m, rng_between(r, -900, 900), rng_between(r, -900, 900),
                                rng_between(r, 0, 900), size, size * 1.5, size * 0.7);
        for (int k = 0; k < 3; ++k) {
            m->bodies[id].velocity[k] = (float)rng_between(r, -9, 9);
            m->bodies[id].angular_velocity[k] = (float)rng_between(r, -9, 9);
        }
        m->bodies[id].mass = (float)exp2(rng_between(r, -9, 9));
    }
    return m;
}

static double plain_kinetic(const mover *m)
{
    double sum = 0;
    for (uint32_t i = 0; i < m->n; ++i)
        for (int k = 0; k < 3; ++k)
            sum += m->bodies[i].mass * m->states[i].velocity[k] * m->states[i].velocity[k];
    return sum;
}

// A body that touches nothing flies alike in each place.
TEST(energies_have_the_same_bits_in_any_order)
{
    rng r = rng_seed(test_seed());
    mover *m = make_flight(&r);
    mover_run(m, 3);
    const duet_energy right = mover_energy(m);
    const double plain = plain_kinetic(m);
    uint32_t plain_differs = 0;
    for (int i = 0; i < 6; ++i) {
        shuffle(m, &r);
        mover_run(m, 3);
        const duet_energy energy = mover_energy(m);
        assert_memory_equal(&energy, &right, sizeof energy);
        plain_differs += plain_kinetic(m) != plain;
    }
    assert_true(plain_differs > 0); // else the numbers are too tame to tell
}

// Bodies that are read in several parts. The speeds are 1, 2 and so on.
TEST(sums_have_each_body_once)
{
    enum { MANY = 40000 };
    const double n = MANY;
    mover *m = mover_new(3);
    duet_pose *poses = test_alloc(MANY * sizeof *poses);
    duet_body *bodies = test_alloc(MANY * sizeof *bodies);
    duet_state *states = test_alloc(MANY * sizeof *states);
    for (uint32_t i = 0; i < MANY; ++i) {
        poses[i] = (duet_pose){.centre = {3.0f * (float)(i % 200), 3.0f * (float)(i / 200), 0},
                               .half_extents = {0.5f, 0.5f, 0.5f},
                               .rotation = {0, 0, 0, 1}};
        bodies[i] = duet_default_body();
        bodies[i].velocity[0] = (float)(i + 1);
    }
    duet_motion *motion = kept(duet_motion_create(&m->def, poses, bodies, MANY, ERR));
    duet_energy energy;
    uint64_t hash, right = 0;
    must(duet_motion_get_energy(motion, &energy, ERR));
    must(duet_motion_get_hash(motion, &hash, ERR));
    must(duet_motion_get_states(motion, states, ERR));
    for (uint32_t i = 0; i < MANY; ++i)
        right = motion_hash_state(right, &states[i], i);
    assert_true(energy.momentum[0] == n * (n + 1) / 2);
    assert_true(energy.kinetic == n * (n + 1) * (2 * n + 1) / 12);
    assert_int_equal(hash, right);
}

static double plain_extents(const mover *m)
{
    double sum = 0;
    for (uint32_t i = 0; i < m->n; ++i)
        sum += m->poses[i].half_extents[2];
    return sum;
}

TEST(the_mean_extent_has_the_same_bits_in_any_order)
{
    rng r = rng_seed(test_seed());
    mover *m = make_flight(&r);
    mover_run(m, 1);
    const double right = m->motion->extent, plain = plain_extents(m);
    uint32_t plain_differs = 0;
    for (int i = 0; i < 6; ++i) {
        shuffle(m, &r);
        mover_run(m, 1);
        assert_memory_equal(&m->motion->extent, &right, sizeof right);
        plain_differs += plain_extents(m) != plain;
    }
    assert_true(plain_differs > 0);
}

static mover *make_pile(void)
{
    mover *m = mover_new(3);
    mover_add_pile(m, OBJECTS);
    return m;
}

// Each step another device finds each pair.
TEST(plans_that_change_at_each_step_change_no_bit)
{
    static const duet_mode modes[] = {DUET_MODE_SHARED, DUET_MODE_OWN, DUET_MODE_SLAB};
    rng r = rng_seed(test_seed());
    mover *fixed = make_pile(), *m = make_pile();
    for (uint32_t step = 1; step <= 40; ++step) {
        mover_run(fixed, 1);
        mover_run(m, 1);
        if (mover_hash(m) != mover_hash(fixed))
            fail_msg("step %u has another hash", step);
        duet_plan plan = *duet_motion_get_plan(m->motion);
        plan.share = rng_below(&r, DUET_SHARE_ONE + 1);
        plan.mode = modes[rng_below(&r, 3)];
        must(duet_motion_set_plan(m->motion, &plan, ERR));
    }
}

// Bounds count from the first body's origin cell. Wherever that is, bounds hold what they must,
// and all else is as it was.
TEST(the_cell_that_bounds_count_from_changes_no_bit)
{
    static const double far[] = {200, -5000, 70000, 1000000};
    duet_state *right = NULL;
    for (size_t i = 0; i < sizeof far / sizeof far[0]; ++i) {
        mover *m = mover_new(3);
        m->def.origin_edge = 16;
        mover_add_fixed(m, far[i], far[i] / 2, 3, 0.5, 0.5, 0.5);
        mover_add_pyramid(m, 5);
        mover_run(m, 30);
        size_t bytes = (m->n - 1) * sizeof *m->states;
        if (!right) {
            right = test_alloc(bytes);
            memcpy(right, m->states + 1, bytes);
        }
        assert_memory_equal(right, m->states + 1, bytes);
        mover_free(m);
    }
}
