// SPDX-License-Identifier: MIT
// Bodies that begin deep in each other are taken apart and not thrown.
#include "support/mover.h"
#include "support/test.h"

static const double edge = 0.5;

static mover *new_deep(uint32_t dims, bool parts)
{
    mover *m = mover_new(dims);
    m->def.slop = 0.005;
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE | (parts ? DUET_EFFECT_DEPENETRATION : 0);
    return m;
}

// Cubes on a floor, each 10 to 20 mm deep in the one below it and a little beside it.
static mover *make_column(uint32_t dims, uint32_t n, bool parts, rng *r)
{
    mover *m = new_deep(dims, parts);
    uint32_t floor = mover_add_floor(m, 10), up = dims - 1;
    m->bodies[floor].friction = 0.6f;
    double top = 0.0;
    for (uint32_t i = 0; i < n; ++i) {
        top -= rng_between(r, 0.01, 0.02);
        double at[3] = {rng_between(r, -0.01, 0.01), dims == 3 ? rng_between(r, -0.01, 0.01) : 0,
                        0};
        at[up] = top + edge / 2;
        uint32_t id = mover_add_cube(m, at[0], at[1], at[2], edge);
        m->bodies[id].friction = 0.6f;
        top += edge;
    }
    return m;
}

static double fastest_in(mover *m, uint32_t steps)
{
    double fastest = 0.0;
    for (uint32_t i = 0; i < steps; ++i) {
        mover_run(m, 1);
        fastest = fmax(fastest, mover_greatest_speed(m));
    }
    return fastest;
}

// Without gravity every speed is one that the push out of depth gave. Springs alone throw a
// column of ten at a metre a second.
TEST(columns_that_begin_deep_are_not_thrown)
{
    rng r = rng_seed(test_seed());
    for (uint32_t n = 2; n <= 10; n += 2)
        for (uint32_t dims = 2; dims <= 3; ++dims) {
            mover *m = make_column(dims, n, true, &r), *springs = make_column(dims, n, false, &r);
            m->def.gravity[dims - 1] = springs->def.gravity[dims - 1] = 0.0;
            double fastest = fastest_in(m, 60), thrown = fastest_in(springs, 60);
            print_message("%uD, %u cubes: %.3f m/s, by springs %.3f\n", dims, n, fastest, thrown);
            assert_true(fastest < 0.08);
            assert_true(n < 10 || thrown > 0.5);
        }
}

// 40 cards of a house, each up to 20 mm from where it should be in height and along the house.
TEST(cards_that_begin_deep_are_not_thrown)
{
    rng r = rng_seed(test_seed());
    for (int house = 0; house < 4; ++house) {
        mover *m = new_deep(3, true);
        mover_add_card_house(m, 5);
        for (uint32_t i = 1; i < m->n; ++i) {
            m->poses[i].centre[0] += (float)rng_between(&r, -0.02, 0.02);
            m->poses[i].centre[2] += (float)rng_between(&r, -0.02, 0.02);
        }
        m->def.gravity[2] = 0.0;
        double fastest = fastest_in(m, 60);
        print_message("house %d: %.3f m/s\n", house, fastest);
        assert_true(fastest < 0.06);
    }
}

// With gravity a column comes to stand, as high as its cubes are.
TEST(a_column_that_begins_deep_stands)
{
    rng r = rng_seed(test_seed());
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        mover *m = make_column(dims, 8, true, &r);
        mover_run(m, 1);
        double risen = m->states[8].centre[dims - 1];
        assert_close(risen, 7.5 * edge, 0.01);
        double fastest = fastest_in(m, 240);
        print_message("%uD: %.3f m/s\n", dims, fastest);
        assert_true(fastest < 0.2);
        assert_close(m->states[8].centre[dims - 1], risen, 0.01);
        assert_close(mover_greatest_speed(m), 0.0, 0.01);
    }
}

// Masses share the way, and what has none stays.
TEST(masses_share_the_way)
{
    mover *m = new_deep(3, true);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_add_cube(m, 0.96, 0, 0, 1);
    m->bodies[1].mass = 3.0f;
    mover_add_cube(m, 0, 5, 0, 1);
    mover_add_cube(m, 0.96, 5, 0, 1);
    m->bodies[2].mass = 0.0f;
    mover_run(m, 1);
    assert_close(m->states[0].centre[0], -0.03, 0.001);
    assert_close(m->states[1].centre[0], 0.97, 0.001);
    assert_close(m->states[0].centre[0] + 3 * m->states[1].centre[0], 3 * 0.96, 1e-5);
    assert_close(m->states[2].centre[0], 0.0, 0.0);
    assert_close(m->states[3].centre[0], 1.0, 0.001);
}

// What touches by a slop at most, and what only senses, keeps its place; no bit is another.
TEST(what_does_not_begin_deep_keeps_its_bits)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        uint64_t hashes[2];
        for (int parts = 0; parts < 2; ++parts) {
            mover *m = new_deep(dims, parts == 1);
            mover_add_floor(m, 10);
            for (int i = 0; i < 40; ++i) { // columns whose cubes overlap by 0 to 4.9 mm
                double beside = 0.6 * (i % 8), up = edge / 2 + (i / 8) * (edge - 7e-4 * (i % 8));
                mover_add_rough_cube(m, beside, dims == 3 ? 0.1 * (i / 8) : up, up);
                for (int k = 0; k < 3; ++k)
                    m->poses[m->n - 1].half_extents[k] = (float)(edge / 2);
            }
            uint32_t eye = mover_add_cube(m, 0.2, 0.2, 0.2, 3.0);
            m->bodies[eye].sensor = true;
            m->bodies[eye].mass = 0.0f;
            mover_run(m, 60);
            hashes[parts] = mover_hash(m);
        }
        assert_true(hashes[0] == hashes[1]);
    }
}

// In double, in origin cells and with a skin, and saved before the first step.
TEST(all_states_are_taken_apart)
{
    for (int kind = 0; kind < 3; ++kind) {
        mover *pair[2];
        for (int k = 0; k < 2; ++k) {
            rng r = rng_seed(7);
            mover *m = pair[k] = make_column(3, 6, true, &r);
            m->def.gravity[2] = 0.0;
            m->def.doubles = kind == 0;
            m->def.origin_edge = kind == 1 ? 1.0f : 0.0f;
            m->def.skin = kind == 2 ? 0.05 : 0.0;
            mover_run(m, 0);
        }
        must(duet_motion_save(pair[0]->motion, "deep", ERR));
        must(duet_motion_load(pair[1]->motion, "deep", ERR));
        assert_true(fastest_in(pair[0], 30) < 0.08);
        mover_run(pair[1], 30);
        assert_true(mover_hash(pair[0]) == mover_hash(pair[1]));
    }
}
