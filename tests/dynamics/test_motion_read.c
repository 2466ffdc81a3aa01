// SPDX-License-Identifier: MIT
// States of some bodies, against those of all.
#include "support/mover.h"
#include "support/test.h"

enum { SOME = 100 };

static mover *new_pile(int way)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.sleep_speed = 0.3;
    m->def.sleep_after = 0.2;
    m->def.doubles = way == 1;
    mover_add_pile(m, SOME);
    if (way == 2) {
        m->def.boundary = DUET_BOUNDARY_NONE;
        m->def.origin_edge = 1;
        m->def.origin[0] = 1e6;
    }
    for (uint32_t id = 20; id < 25; ++id)
        m->bodies[id].mass = 0;
    return m;
}

TEST(states_of_ids_are_those_of_all)
{
    rng r = rng_seed(test_seed());
    for (int way = 0; way < 3; ++way) {
        mover *m = new_pile(way);
        for (int step = 0; step < 5; ++step) {
            uint32_t ids[SOME / 2];
            duet_state some[SOME / 2];
            mover_run(m, 10);
            for (int i = 0; i < SOME / 2; ++i)
                ids[i] = rng_below(&r, SOME);
            must(duet_motion_get_states_of(m->motion, ids, SOME / 2, some, ERR));
            for (int i = 0; i < SOME / 2; ++i)
                assert_memory_equal(&some[i], &m->states[ids[i]], sizeof some[i]);
        }
    }
}

static bool is_elsewhere(const duet_state *a, const duet_state *b)
{
    return memcmp(a->centre, b->centre, sizeof a->centre) != 0 ||
           memcmp(a->rotation, b->rotation, sizeof a->rotation) != 0;
}

TEST(what_moved_is_what_differs_from_the_last_read)
{
    for (int way = 0; way < 3; ++way) {
        mover *m = new_pile(way);
        static duet_state last[SOME];
        uint32_t still = 0;
        for (int read = 0; read < 60; ++read) {
            duet_moved moved;
            mover_run(m, 1 + read % 4);
            must(duet_motion_get_moved(m->motion, &moved, ERR));
            uint32_t at = 0;
            for (uint32_t id = 0; id < m->n; ++id) {
                if (read > 0 && !is_elsewhere(&last[id], &m->states[id]))
                    continue;
                assert_true(at < moved.n);
                assert_int_equal(moved.places[at], id);
                assert_memory_equal(&moved.states[at], &m->states[id], sizeof last[id]);
                ++at;
            }
            assert_int_equal(at, moved.n);
            still += m->n - at;
            memcpy(last, m->states, sizeof last);
        }
        assert_true(still > 5 * 59);
    }
}

TEST(nothing_moved_where_everything_rests)
{
    duet_moved moved;
    mover *m = mover_new(2);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_run(m, 1);
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    assert_int_equal(moved.n, 1);
    mover_run(m, 3);
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    assert_int_equal(moved.n, 0);
}

// A turn of 90 degrees about z, and half of it.
TEST(half_way_is_half_of_the_turn)
{
    const double half = sqrt(0.5);
    const duet_state from = {.centre = {1, 2, 3}, .rotation = {0, 0, 0, 1}, .velocity = {4, 0, 0}};
    const duet_state to = {.centre = {3, 2, 7},
                           .rotation = {0, 0, -half, -half}}; // the same as half, half
    duet_state middle = duet_state_between(&from, &to, 0.5);
    assert_true(middle.centre[0] == 2 && middle.centre[1] == 2 && middle.centre[2] == 5);
    assert_true(middle.velocity[0] == 2);
    assert_close(middle.rotation[2], sin(acos(-1) / 8), 1e-15);
    assert_close(middle.rotation[3], cos(acos(-1) / 8), 1e-15);
    duet_state begin = duet_state_between(&from, &to, 0), end = duet_state_between(&from, &to, 1);
    assert_memory_equal(&begin, &from, sizeof from);
    assert_true(!memcmp(end.centre, to.centre, sizeof to.centre));
    assert_close(end.rotation[2], half, 1e-15);
    for (int i = 0; i <= 20; ++i) { // within a third of a degree for 45 degrees
        double angle = acos(-1) / 4, t = i / 20.0;
        const duet_state turned = {.rotation = {0, 0, sin(angle / 2), cos(angle / 2)}};
        duet_state at = duet_state_between(&from, &turned, t);
        assert_close(2 * atan2(at.rotation[2], at.rotation[3]), t * angle, 0.0058);
    }
}

TEST_MAIN(mover_open_pair, mover_close_pair)
