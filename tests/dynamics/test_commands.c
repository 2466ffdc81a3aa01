// SPDX-License-Identifier: MIT
// Commands to a motion: what is set, pushed or aimed at, and bodies that come and go.
#include "support/commands.h"

#include "base/text_file.h"

#include "runtime/dynamics/motion.h"

static const char path[] = "motion"; // name of the file that a test saves

static uint32_t n_asleep(mover *m)
{
    uint32_t n = 0;
    for (uint32_t id = 0; id < duet_motion_get_count(m->motion); ++id)
        n += mover_speed(m, id) == 0.0;
    return n;
}

// ------------------------------------------------------------ what is set

TEST(a_field_that_is_set_is_what_the_step_begins_with)
{
    mover *m = make_rows(3, 1);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 4);
    const duet_body fast = {.velocity = {1, 2, 6}, .angular_velocity = {0, 0, 3}, .mass = 9};
    must(duet_motion_set_bodies(m->motion, one(2), DUET_BODY_VELOCITY, &fast, ERR));
    must(duet_motion_get_states(m->motion, m->states, ERR));
    assert_close(m->states[2].velocity[2], 6, 0);
    assert_close(m->states[2].angular_velocity[2], 0, 0);
    mover_run(m, 1);
    assert_close(m->states[2].velocity[2], 6 - 9.81 / 60, 1e-4);
    assert_close(mover_speed(m, 1) + mover_speed(m, 3), 0, 0); // they sleep on
    duet_energy before = mover_energy(m);
    must(duet_motion_set_bodies(m->motion, one(2), DUET_BODY_MASS, &fast, ERR));
    assert_close(mover_energy(m).momentum[2], 9 * before.momentum[2], 1e-5);
}

TEST(a_pose_that_is_set_wakes_and_falls)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    duet_pose high = m->poses[1];
    high.centre[2] = 10;
    high.half_extents[2] = 1;
    must(duet_motion_set_poses(m->motion, one(1), &high, ERR));
    mover_run(m, 1);
    assert_close(m->states[1].centre[2], 10, 0.01);
    mover_run(m, 200);
    assert_close(m->states[1].centre[2], 1, 0.01);
}

TEST(wrong_commands_are_refused_by_name_and_change_nothing)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 50);
    m->bodies[0].friction = 0;
    uint32_t cube = mover_add_cube(m, 0, 0, 0.5, 1);
    m->bodies[cube].fixed_rotation = true;
    mover_run(m, 3);
    uint64_t hash = mover_hash(m);
    duet_motion *motion = m->motion;
    duet_body b = duet_default_body();
    const uint64_t ids[2] = {1, 2}, again[2] = {1, 1};
    const duet_force force = {.force = {0, NAN, 0}};
    const duet_impulse impulse = {.impulse = {INFINITY, 0, 0}};
    const duet_transform there = {.rotation = {0, 0, 0, 1}};
    const uint32_t mass = DUET_BODY_MASS, friction = DUET_BODY_FRICTION;
    b.mass = -1;
    must_fail(duet_motion_set_bodies(motion, one(1), mass, &b, ERR), ANY_FAILURE, "mass must be 0");
    b = duet_default_body();
    b.friction = 0.5f;
    must_fail(duet_motion_set_bodies(motion, one(1), friction, &b, ERR), ANY_FAILURE,
              "body 0 of 1 needs the effect friction");
    b.fixed_rotation = false;
    must_fail(duet_motion_set_bodies(motion, one(1), DUET_BODY_FIXED_ROTATION, &b, ERR),
              ANY_FAILURE, "needs the effect angular_velocity");
    must_fail(duet_motion_set_bodies(motion, one(1), 1u << 30, &b, ERR), ANY_FAILURE,
              "duet_body_field");
    must_fail(duet_motion_set_bodies(motion, one(2), mass, &b, ERR), ANY_FAILURE, "no body 2");
    must_fail(duet_motion_set_bodies(motion, by_ids(ids, 2), mass, &b, ERR), ANY_FAILURE,
              "no body 2");
    must_fail(duet_motion_remove_bodies(motion, by_ids(again, 2), ERR), ANY_FAILURE,
              "listed twice");
    must_fail(duet_motion_apply_forces(motion, one(1), &force, ERR), ANY_FAILURE, "effect forces");
    must_fail(duet_motion_sleep_bodies(motion, one(1), ERR), ANY_FAILURE, "effect sleep");
    must_fail(duet_motion_apply_impulses(motion, one(1), &impulse, ERR), ANY_FAILURE, "not finite");
    must_fail(duet_motion_set_targets(motion, one(1), &there, ERR), ANY_FAILURE, "mass of 1");
    m->poses[1].rotation[0] = 1;
    must_fail(duet_motion_set_poses(motion, one(1), &m->poses[1], ERR), ANY_FAILURE,
              "effect rotation");
    m->poses[1].half_extents[0] = -1;
    must_fail(duet_motion_add_bodies(motion, &m->poses[1], NULL, 1, NULL, ERR), ANY_FAILURE,
              "half extent is negative");
    duet_motion_def def = *duet_motion_get_def(motion);
    def.dt = 1;
    must_fail(duet_motion_set_def(motion, &def, ERR), ANY_FAILURE,
              "dt is 1; expected the motion's");
    def = *duet_motion_get_def(motion);
    def.drag = 1;
    must_fail(duet_motion_set_def(motion, &def, ERR), ANY_FAILURE, "effect drag");
    assert_true(mover_hash(m) == hash);
    mover_run(m, 1);
}

// A weight alone pushes nothing, nor does a rough thing without one.
TEST(what_two_bodies_call_for_together_is_asked_of_the_motion)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT;
    m->bodies[mover_add_cube(m, 0, 0, 0, 1)].mass = 0;
    mover_run(m, 1);
    duet_pose there[2] = {m->poses[0], m->poses[0]};
    duet_body bodies[2] = {duet_default_body(), duet_default_body()};
    bodies[1].mass = 0;
    bodies[1].friction = 0.5f;
    must_fail(duet_motion_add_bodies(m->motion, there, bodies, 2, NULL, ERR), ANY_FAILURE,
              "body 1 of 2 needs the effect contact_response");
    assert_int_equal(duet_motion_get_count(m->motion), 1);
    must(duet_motion_add_bodies(m->motion, there, bodies, 1, NULL, ERR));
    must_fail(duet_motion_add_bodies(m->motion, &there[1], &bodies[1], 1, NULL, ERR), ANY_FAILURE,
              "body 0 of 1 needs the effect contact_response");
}

TEST(gravity_can_change_while_all_sleep)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 3);
    duet_motion_def def = *duet_motion_get_def(m->motion);
    def.gravity[2] = 3;
    must(duet_motion_set_def(m->motion, &def, ERR));
    mover_run(m, 60);
    assert_close(m->states[1].velocity[2], 3, 0.05);
}

// ------------------------------------------------------------ what pushes

TEST(a_force_holds_for_one_step_and_can_carry_a_weight)
{
    for (int free_flight = 0; free_flight < 2; ++free_flight)
        for (int doubles = 0; doubles < 2; ++doubles) {
            mover *m = mover_new(3);
            m->def.wants = DUET_EFFECT_FORCES | DUET_EFFECT_ANGULAR_VELOCITY |
                           (free_flight ? 0 : DUET_EFFECT_CONTACT_RESPONSE);
            m->def.doubles = doubles;
            m->def.gravity[2] = -10;
            uint32_t id = mover_add(m, 0, 0, 5, 0.5, 0.25, 0.5);
            m->bodies[id].mass = 2;
            mover_run(m, 0);
            // 2/3 of a kg m^2 about y, so that a second of 1 N m gives 12 / 2 rad/s
            const duet_force lift = {.force = {0, 0, 20}, .torque = {0, 1, 0}};
            for (int step = 0; step < 60; ++step) {
                must(duet_motion_apply_forces(m->motion, one(id), &lift, ERR));
                mover_run(m, 1);
            }
            double inertia = 2.0 / 3 * (0.25 + 0.25);
            assert_close(m->states[id].centre[2], 5, 1e-5);
            assert_close(m->states[id].angular_velocity[1], 1 / inertia, 1e-4);
            mover_run(m, 60);
            assert_close(m->states[id].velocity[2], -10, 1e-4);
        }
}

TEST(an_impulse_beside_the_centre_turns)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_ANGULAR_VELOCITY;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 2);
    mover_turn(m, id, 1, 2, 3, 0.7);
    m->bodies[id].mass = 3;
    mover_run(m, 0);
    const duet_impulse hit = {.impulse = {0, 6, 0}, .anchor = {0.5f, 0, 0}};
    must(duet_motion_apply_impulses(m->motion, one(id), &hit, ERR));
    mover_run(m, 1);
    assert_close(m->states[id].velocity[1], 2, 1e-6);
    assert_close(m->states[id].angular_velocity[2], 0.5 * 6 / 2, 1e-6); // a cube: m/6 edge^2
}

// ------------------------------------------------------------ kinematic bodies

TEST(a_target_is_reached_exactly_and_carries_what_lies_on_it)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.sleep_after = 0.1;
    mover_add_floor(m, 20);
    uint32_t lift = mover_add_fixed(m, 0, 0, 1, 2, 2, 0.25);
    m->bodies[lift].friction = 0.6f;
    uint32_t load = mover_add_rough_cube(m, 0, 0, 1.75);
    mover_run(m, 60);
    assert_close(mover_speed(m, load), 0, 0);
    for (int step = 1; step <= 120; ++step) {
        float angle = 0.5f * (float)step / 120;
        const duet_transform there = {{(float)step / 100, 0, 1 + (float)step / 60},
                                      {0, 0, sinf(angle / 2), cosf(angle / 2)}};
        must(duet_motion_set_targets(m->motion, one(lift), &there, ERR));
        must(duet_motion_get_states(m->motion, m->states, ERR));
        assert_close(m->states[lift].velocity[2], 1, 1e-4);
        mover_run(m, 1);
        assert_close(m->states[lift].centre[2], (double)there.centre[2], 0);
        assert_close(m->states[lift].centre[0], (double)there.centre[0], 0);
        assert_close(mover_speed(m, lift), 0, 0);
    }
    assert_close(m->states[load].centre[2], 3.75, 0.02);
    assert_close(m->states[load].centre[0], 1.2, 0.05);
    assert_close(2 * atan2(m->states[load].rotation[2], m->states[load].rotation[3]), 0.5, 0.05);
    mover_run(m, 60);
    assert_close(m->states[lift].centre[2], 3, 1e-6);
    assert_close(mover_speed(m, load), 0, 0);
}

TEST(what_has_no_mass_and_moves_wakes_what_it_newly_reaches)
{
    mover *m = make_rows(2, 1);
    uint32_t ram = mover_add_fixed(m, -3, 0, 0.6, 0.5, 0.5, 0.5);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 4);
    const duet_body pushes = {.velocity = {2, 0, 0}};
    must(duet_motion_set_bodies(m->motion, one(ram), DUET_BODY_VELOCITY, &pushes, ERR));
    mover_run(m, 90); // 2 m to the first cube, and then 1 m with it
    assert_close(m->states[1].centre[0], 1, 0.05);
}

TEST(a_target_wakes_what_it_reaches_in_one_step)
{
    mover *m = make_rows(1, 1);
    uint32_t ram = mover_add_fixed(m, 8, 0, 0.6, 0.5, 0.5, 0.5);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 3);
    const duet_transform there = {{0.8f, 0, 0.6f}, {0, 0, 0, 1}};
    must(duet_motion_set_targets(m->motion, one(ram), &there, ERR));
    mover_run(m, 30);
    assert_true(m->states[1].centre[0] < -0.1); // pushed out
}

TEST(what_has_no_mass_and_is_put_elsewhere_wakes_its_neighbours)
{
    mover *m = make_rows(2, 1);
    uint32_t shelf = mover_add_fixed(m, 20, 0, 3, 1, 1, 0.25);
    uint32_t book = mover_add_rough_cube(m, 20, 0, 3.75);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 5);
    duet_pose away = m->poses[shelf];
    away.centre[0] = 0.9f; // into the first cube
    away.centre[2] = 0.25f;
    must(duet_motion_set_poses(m->motion, one(shelf), &away, ERR));
    mover_run(m, 30);
    assert_true(m->states[book].centre[2] < 3); // nothing holds it
    assert_true(m->states[1].centre[2] > 0.6);  // pushed out
}

// ------------------------------------------------------------ bodies that come and go

TEST(ids_are_handles_and_places_are_used_again)
{
    mover *m = make_rows(4, 1);
    mover_run(m, 1);
    duet_motion *motion = m->motion;
    const uint64_t going[2] = {3, 1};
    uint64_t ids[5] = {0};
    must(duet_motion_remove_bodies(motion, by_ids(going, 2), ERR));
    assert_false(duet_motion_has_body(motion, 1));
    assert_true(duet_motion_has_body(motion, 2));
    must_fail(duet_motion_wake_bodies(motion, by_ids(going, 1), ERR), ANY_FAILURE,
              "id 3 was removed");
    must_fail(duet_motion_wake_bodies(motion, one(1), ERR), ANY_FAILURE, "was removed");
    const duet_pose pose = {{-5, 0, 5}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_pose poses[3] = {pose, pose, pose};
    must(duet_motion_add_bodies(motion, poses, NULL, 1, ids, ERR));
    assert_true(ids[0] == 5); // the places that were left are empty after the step
    mover_run(m, 1);
    must(duet_motion_add_bodies(motion, poses, NULL, 3, ids, ERR));
    const uint64_t second = UINT64_C(1) << 32;
    assert_true(ids[0] == (second | 1) && ids[1] == (second | 3) && ids[2] == 6);
    must_fail(duet_motion_wake_bodies(motion, by_ids(going, 1), ERR), ANY_FAILURE,
              "id 3 was removed");
    assert_true(duet_motion_has_body(motion, ids[1]));
    must(duet_motion_remove_bodies(motion, by_ids(ids, 1), ERR));
    must(duet_motion_get_ids(motion, 0, 5, ids, ERR));
    assert_true(ids[0] == 0 && ids[1] == DUET_NO_BODY && ids[3] == (second | 3) && ids[4] == 4);
    const uint64_t data[2] = {77, UINT64_MAX};
    uint64_t read[2] = {0};
    const duet_body_list two = {.first = 2, .n = 2};
    must(duet_motion_set_user_data(motion, two, data, ERR));
    must(duet_motion_get_user_data(motion, two, read, ERR));
    assert_memory_equal(read, data, sizeof data);
}

TEST(what_lay_on_a_removed_body_falls)
{
    for (int disabled = 0; disabled < 2; ++disabled) {
        mover *m = make_rows(2, 3);
        m->def.skin = disabled ? 0.2 : 0;
        mover_run(m, 60);
        assert_int_equal(n_asleep(m), 7);
        if (disabled)
            must(duet_motion_disable_bodies(m->motion, one(1), ERR));
        else
            must(duet_motion_remove_bodies(m->motion, one(1), ERR));
        mover_run(m, 1);
        mover_run(m, 1);
        assert_true(m->states[2].velocity[2] < -0.1);
        assert_close(mover_speed(m, 4) + mover_speed(m, 5) + mover_speed(m, 6), 0, 0);
        mover_run(m, 120);
        assert_close(m->states[2].centre[2], 0.5, 0.02);
        assert_close(m->states[3].centre[2], 1.5, 0.02);
        if (disabled) { // it comes back inside another, and both part
            assert_close(m->states[1].centre[2], 0.5, 0.02);
            must(duet_motion_enable_bodies(m->motion, one(1), ERR));
            mover_run(m, 120);
            assert_true(fabs(m->states[2].centre[2] - m->states[1].centre[2]) > 0.9 ||
                        fabs(m->states[2].centre[0] - m->states[1].centre[0]) > 0.9 ||
                        fabs(m->states[2].centre[1] - m->states[1].centre[1]) > 0.9);
        }
        mover_assert_finite(m);
    }
}

TEST(a_body_that_comes_falls_as_one_that_was_there)
{
    duet_state states[2][8];
    for (int late = 0; late < 2; ++late) {
        mover *m = make_rows(2, 1);
        mover_wall_in(m, -0.5, 8);
        const duet_pose pose = {{6, 3, 2}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
        duet_body b = duet_default_body();
        b.friction = 0.6f;
        if (!late) {
            uint32_t id = mover_add_cube(m, 6, 3, 2, 1);
            m->bodies[id] = b;
        }
        mover_run(m, 0);
        if (late)
            must(duet_motion_add_bodies(m->motion, &pose, &b, 1, NULL, ERR));
        m->n = 4;
        mover_run(m, 90);
        memcpy(states[late], m->states, sizeof states[late]);
    }
    assert_memory_equal(states[0], states[1], 4 * sizeof states[0][0]);
}

TEST(a_motion_can_begin_empty)
{
    mover *m = mover_new(3);
    m->def.gravity[2] = -10;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_GRAVITY | DUET_EFFECT_FRICTION |
                   DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_SLEEP;
    mover_run(m, 2);
    uint32_t floor = mover_add_floor(m, 5), brick = mover_add(m, 0, 0, 2, 0.5, 0.25, 0.125);
    mover_turn(m, brick, 1, 1, 0, 0.5);
    m->bodies[brick].friction = 0.5f;
    must(duet_motion_add_bodies(m->motion, m->poses, m->bodies, 2, NULL, ERR));
    mover_run(m, 300);
    assert_close(m->states[floor].centre[2], -0.5, 0);
    assert_close(m->states[brick].centre[2], 0.125, 0.01);
    assert_close(mover_speed(m, brick), 0, 0);
}

TEST(a_floor_can_get_a_mass)
{
    mover *m = make_rows(4, 2);
    uint32_t plate = mover_add_fixed(m, 0, 20, 10, 3, 3, 0.25);
    for (int i = 0; i < 9; ++i)
        mover_add_rough_cube(m, 1.5 * (i % 3) - 1.5, 20 + 1.5 * (i / 3) - 1.5, 10.75);
    mover_run(m, 60);
    const duet_body heavy = {.mass = 50};
    must(duet_motion_set_bodies(m->motion, one(plate), DUET_BODY_MASS, &heavy, ERR));
    mover_run(m, 240);
    assert_close(m->states[plate].centre[2], 0.25, 0.02);
    for (uint32_t id = plate + 1; id < m->n; ++id)
        assert_close(m->states[id].centre[2], 1, 0.05);
}

// Whether a search dropped what it touched before or kept it within its skin is the same.
TEST(what_is_sent_to_sleep_in_flight_does_not_depend_on_the_skin)
{
    enum { N = 60 };
    uint64_t hashes[2];
    for (int k = 0; k < 2; ++k) {
        mover *m = make_rows(N, 1);
        m->def.skin = 0.5 * k;
        for (uint32_t i = 1; i <= N; ++i) {
            m->poses[i].centre[2] = 0.7f;
            m->bodies[i].restitution = 0.9f;
        }
        for (uint32_t i = 1; i <= N; ++i) {
            mover_run(m, 1);
            must(duet_motion_sleep_bodies(m->motion, one(i), ERR));
        }
        mover_run(m, 10);
        hashes[k] = mover_hash(m);
    }
    assert_true(hashes[0] == hashes[1]);
}

TEST(who_sleeps_is_told)
{
    mover *m = make_rows(3, 1);
    uint8_t asleep[4];
    mover_run(m, 1);
    must(duet_motion_sleep_bodies(m->motion, (duet_body_list){.first = 1, .n = 2}, ERR));
    mover_run(m, 1);
    must(duet_motion_get_asleep(m->motion, asleep, ERR));
    assert_memory_equal(asleep, ((const uint8_t[]){0, 1, 1, 0}), 4);
    must(duet_motion_wake_bodies(m->motion, one(1), ERR));
    must(duet_motion_remove_bodies(m->motion, one(2), ERR));
    must(duet_motion_get_asleep(m->motion, asleep, ERR));
    assert_memory_equal(asleep, ((const uint8_t[]){0, 0, 0, 0}), 4);
}

// How far a box reaches down from its centre.
static double depth_of(const duet_pose *p)
{
    const float *q = p->rotation, *h = p->half_extents;
    double norm = 0, x, y, z;
    for (int k = 0; k < 4; ++k)
        norm += (double)q[k] * q[k];
    x = 2.0 * (q[0] * (double)q[2] - q[3] * (double)q[1]) / norm;
    y = 2.0 * (q[1] * (double)q[2] + q[3] * (double)q[0]) / norm;
    z = 1.0 - 2.0 * (q[0] * (double)q[0] + q[1] * (double)q[1]) / norm;
    return fabs(x) * h[0] + fabs(y) * h[1] + fabs(z) * h[2];
}

// Boxes just above a floor or a wall turn and fly so fast that the next step would bring many of
// them there, but they are sent to sleep where they are.
TEST(what_is_sent_to_sleep_on_its_way_never_arrives)
{
    enum { N = 60 };
    uint64_t ids[N];
    for (int k = 0; k < 4; ++k) {
        mover *m = mover_new(3);
        rng r = rng_seed(5);
        bool wall = k / 2;
        m->def.wants = DUET_EFFECT_SLEEP | DUET_EFFECT_CONTINUOUS | DUET_EFFECT_EVENTS |
                       DUET_EFFECT_ANGULAR_VELOCITY;
        m->def.skin = 0.5 * (k % 2);
        m->def.boundary = wall ? DUET_BOUNDARY_WALLS : DUET_BOUNDARY_NONE;
        for (int axis = 0; axis < 3; ++axis) {
            m->def.lower[axis] = axis < 2 ? -200 : 0;
            m->def.upper[axis] = 200;
        }
        mover_add_floor(m, 200);
        m->poses[0].centre[2] -= wall ? 10 : 0;
        for (uint32_t i = 0; i < N; ++i) {
            uint32_t box = mover_add(m, 3.0 * i - 90, 0, 0, 0.5, 0.1, 0.2);
            duet_body *b = &m->bodies[box];
            mover_turn(m, box, rng_between(&r, -1, 1), rng_between(&r, -1, 1), 1, 1.5);
            m->poses[box].centre[2] =
                (float)(depth_of(&m->poses[box]) + rng_between(&r, 0.001, 0.05));
            b->velocity[2] = (float)rng_between(&r, -3, 3);
            for (int axis = 0; axis < 3; ++axis)
                b->angular_velocity[axis] = (float)rng_between(&r, -30, 30);
            ids[i] = box;
        }
        mover_run(m, 0);
        must(duet_motion_sleep_bodies(m->motion, by_ids(ids, N), ERR));
        for (int step = 0; step < 3; ++step) {
            mover_run(m, 1);
            assert_close(mover_greatest_speed(m), 0, 0);
            assert_int_equal(m->last.n_events, 0);
            assert_int_equal(m->last.n_stays, 0);
        }
    }
}

// ------------------------------------------------------------ a search of some

// The first world searches all, the second where it can only some.
static void assert_rests_alike(mover *twins[2], bool some)
{
    duet_contact *contacts[2];
    uint64_t n[2];
    motion_alter_all(twins[0]->motion);
    for (int k = 0; k < 2; ++k) {
        mover_run(twins[k], 1);
        assert_true(mover_has_stage(twins[k], "altered_pairs") == (some && k > 0));
        assert_true(mover_has_stage(twins[k], "pairs") == !(some && k > 0));
        contacts[k] = mover_contacts(twins[k], &n[k]);
    }
    assert_true(mover_hash(twins[0]) == mover_hash(twins[1]));
    assert_true(n[0] == n[1]);
    for (uint64_t i = 0; i < n[0]; ++i)
        assert_true(contacts[0][i].a == contacts[1][i].a && contacts[0][i].b == contacts[1][i].b &&
                    contacts[0][i].n == contacts[1][i].n);
}

#define do_both(call)                            \
    for (int k_ = 0; k_ < 2; ++k_) {             \
        duet_motion *motion = twins[k_]->motion; \
        must(call);                              \
    }

TEST(only_what_commands_altered_is_searched_within_a_skin)
{
    enum { ROWS = 16, HIGH = 4, PEBBLES = 7 };
    // The last one is wider than the table of the others.
    duet_pose poses[PEBBLES + 1] = {
        [PEBBLES] = {{20, 0, HIGH + 20.005f}, {20, 20, 20}, {0, 0, 0, 1}}};
    for (int i = 0; i < PEBBLES; ++i) {
        const duet_pose pebble = {{3 + 0.5f * (float)i, 9, 0.2f}, {.25f, .25f, .25f}, {0, 0, 0, 1}};
        poses[i] = pebble;
    }
    const duet_body alone = {.group = 2, .mask = 1};
    mover *twins[2];
    for (int k = 0; k < 2; ++k) {
        twins[k] = make_rows(ROWS, HIGH);
        twins[k]->def.skin = 0.2;
        twins[k]->def.wants |= DUET_EFFECT_FILTER;
        twins[k]->def.stage_times = true;
        mover_run(twins[k], 60);
        assert_int_equal(n_asleep(twins[k]), ROWS * HIGH + 1);
    }
    do_both(duet_motion_remove_bodies(motion, one(2), ERR));
    assert_rests_alike(twins, true);
    do_both(duet_motion_add_bodies(motion, poses, NULL, PEBBLES + 1, NULL, ERR));
    assert_rests_alike(twins, true);
    do_both(duet_motion_disable_bodies(motion, one(10), ERR));
    assert_rests_alike(twins, true);
    do_both(duet_motion_enable_bodies(motion, one(10), ERR));
    do_both(duet_motion_set_bodies(motion, one(10), DUET_BODY_FILTER, &alone, ERR));
    do_both(duet_motion_set_bodies(motion, one(13), DUET_BODY_FILTER, &alone, ERR));
    assert_rests_alike(twins, true);
    do_both(duet_motion_remove_bodies(motion, one(0), ERR)); // the floor, which all rest on
    assert_rests_alike(twins, true);
    const duet_body_list many = {.first = 5, .n = 12};
    do_both(duet_motion_disable_bodies(motion, many, ERR));
    assert_rests_alike(twins, false);
}

// ------------------------------------------------------------ two halves

// While a step is under way the motion is for those who ask what does not change in it.
TEST(nothing_is_done_to_a_motion_between_the_halves_of_its_step)
{
    mover *m = make_rows(4, 2), *twin = make_rows(4, 2);
    mover_run(m, 1);
    mover_run(twin, 1);
    duet_motion *motion = m->motion;
    const duet_pose pose = {{0, 5, 3}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_transform there = {{0, 5, 3}, {0, 0, 0, 1}};
    const duet_force force = {0};
    const duet_impulse impulse = {0};
    const uint64_t data = 1;
    const uint32_t place = 1;
    duet_motion_def def = *duet_motion_get_def(motion);
    duet_motion_result result;
    duet_contact *contacts;
    duet_energy energy;
    duet_moved moved;
    uint64_t n, ids[9];
    uint8_t asleep[9];
    must_fail(duet_motion_advance_end(motion, &result, ERR), ANY_FAILURE, "no step is under way");
    must(duet_motion_remove_bodies(motion, one(3), ERR));
    must(duet_motion_remove_bodies(twin->motion, one(3), ERR));
    must(duet_motion_record(motion, ERR));
    must(duet_motion_advance_begin(motion, ERR));
#define BUSY(call)                                                                  \
    do {                                                                            \
        static const char says[] = ": a step of the motion is under way; expected"; \
        must_fail(call, ANY_FAILURE, says);                                         \
        size_t length = (size_t)(strstr(ERR->text, says) - ERR->text);              \
        if (strncmp(ERR->text, #call, length) != 0)                                 \
            fail_msg("%s is told '%s'", #call, ERR->text);                          \
    } while (0)
    BUSY(duet_motion_advance(motion, &result, ERR));
    BUSY(duet_motion_advance_begin(motion, ERR));
    BUSY(duet_motion_add_bodies(motion, &pose, NULL, 1, NULL, ERR));
    BUSY(duet_motion_remove_bodies(motion, one(1), ERR));
    BUSY(duet_motion_enable_bodies(motion, one(1), ERR));
    BUSY(duet_motion_disable_bodies(motion, one(1), ERR));
    BUSY(duet_motion_wake_bodies(motion, one(1), ERR));
    BUSY(duet_motion_sleep_bodies(motion, one(1), ERR));
    BUSY(duet_motion_set_bodies(motion, one(1), DUET_BODY_VELOCITY, m->bodies, ERR));
    BUSY(duet_motion_set_poses(motion, one(1), &pose, ERR));
    BUSY(duet_motion_set_targets(motion, one(0), &there, ERR));
    BUSY(duet_motion_apply_forces(motion, one(1), &force, ERR));
    BUSY(duet_motion_apply_impulses(motion, one(1), &impulse, ERR));
    BUSY(duet_motion_set_def(motion, &def, ERR));
    BUSY(duet_motion_set_user_data(motion, one(1), &data, ERR));
    BUSY(duet_motion_get_user_data(motion, one(1), &n, ERR));
    BUSY(duet_motion_map_states(motion, DUET_STATE_CENTRES, DUET_MAP_READ, 0, 1, ERR));
    BUSY(duet_motion_unmap_states(motion, DUET_STATE_CENTRES, ERR));
    BUSY(duet_motion_get_states(motion, m->states, ERR));
    BUSY(duet_motion_get_states_of(motion, &place, 1, m->states, ERR));
    BUSY(duet_motion_get_moved(motion, &moved, ERR));
    BUSY(duet_motion_get_poses(motion, m->poses, ERR));
    BUSY(duet_motion_get_asleep(motion, asleep, ERR));
    BUSY(duet_motion_get_hash(motion, &n, ERR));
    BUSY(duet_motion_get_energy(motion, &energy, ERR));
    BUSY(duet_motion_get_contacts(motion, &contacts, &n, ERR));
    BUSY(duet_motion_save(motion, path, ERR));
    BUSY(duet_motion_load(motion, path, ERR));
    BUSY(duet_motion_record(motion, ERR));
    BUSY(duet_motion_save_recording(motion, path, ERR));
    assert_true(duet_motion_get_step(motion) == 1 && duet_motion_get_count(motion) == 9);
    must(duet_motion_get_ids(motion, 0, 9, ids, ERR));
    assert_true(ids[3] == DUET_NO_BODY && duet_motion_has_body(motion, 2));
    assert_null(duet_motion_get_plan(motion));
    must(duet_motion_advance_end(motion, &result, ERR));
    mover_run(twin, 1);
    assert_true(result.step == 2 && duet_motion_get_step(motion) == 2);
    assert_true(mover_hash(m) == mover_hash(twin));
    must(duet_motion_advance_begin(motion, ERR));
    mover_free(m); // which waits
}

// A body is disabled while bounds are looked at for what is wrong while the step is under way.
TEST(a_step_that_fails_is_told_in_its_second_half)
{
    for (int disabled = 0; disabled < 2; ++disabled) {
        mover *m = make_rows(3, 1);
        m->def.dt = 100;
        m->bodies[1].velocity[0] = 3e38f;
        mover_run(m, 0);
        duet_motion_result result;
        if (disabled)
            must(duet_motion_disable_bodies(m->motion, one(2), ERR));
        must(duet_motion_advance_begin(m->motion, ERR));
        must_fail(duet_motion_advance_end(m->motion, &result, ERR), ANY_FAILURE,
                  disabled ? "object 1 of 4: its bounds are not finite after step 0"
                           : "is not a number");
        must_fail(duet_motion_advance_begin(m->motion, ERR), ANY_FAILURE,
                  "the motion failed in its step");
    }
}

// ------------------------------------------------------------ files

TEST(a_file_of_another_version_is_refused_by_name)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 1);
    uint64_t hash = mover_hash(m);
    static const char old[] = "duet motion 4\n\0\0";
    must(text_write_file(path, old, sizeof old, ERR));
    must_fail(duet_motion_load(m->motion, path, ERR), ANY_FAILURE,
              ": begins with \"duet motion 4\"; expected \"duet motion 2\"");
    duet_replay *replay = NULL;
    must_fail((replay = duet_replay_create(path, ERR)), ANY_FAILURE,
              ": begins with \"duet motion 4\"; expected \"duet commands 2\"");
    must(text_write_file(path, "\x1b\n", 1, ERR));
    must_fail(duet_motion_load(m->motion, path, ERR), ANY_FAILURE, ": begins with \"\\x1b\"");
    assert_true(mover_hash(m) == hash);
}

// A saved motion has its bodies, so it matters not which ones the motion has meanwhile.
TEST(a_motion_that_got_commands_loads_a_file_from_before_them)
{
    mover *m = make_rows(3, 2);
    mover_run(m, 5);
    must(duet_motion_save(m->motion, path, ERR));
    uint64_t saved = mover_hash(m);
    mover_run(m, 10);
    uint64_t later = mover_hash(m);
    must(duet_motion_remove_bodies(m->motion, one(4), ERR));
    must(duet_motion_add_bodies(m->motion, m->poses, NULL, 2, NULL, ERR));
    must(duet_motion_load(m->motion, path, ERR));
    assert_int_equal(duet_motion_get_count(m->motion), 7);
    assert_true(mover_hash(m) == saved);
    mover_run(m, 10);
    assert_true(mover_hash(m) == later);
}

TEST(what_commands_left_is_saved)
{
    mover *m = make_rows(4, 2), *fresh = make_rows(4, 2);
    uint32_t lift = mover_add_fixed(m, 3, 0, 5, 0.5, 0.5, 0.5);
    mover_add(fresh, 3, 0, 5, 0.5, 0.5, 0.5);
    fresh->bodies[lift].mass = 0;
    mover_run(m, 10);
    mover_run(fresh, 3);
    const uint64_t data = 12345;
    const duet_transform there = {{3, 0, 4.5f}, {0, 0, 0, 1}};
    const duet_force force = {.force = {0, 0, 100}};
    const duet_pose pose = {{-4, 0, 5}, {0.5f, 0.25f, 0.5f}, {0, 0, 0, 1}};
    uint64_t ids[2];
    must(duet_motion_remove_bodies(m->motion, one(1), ERR));
    mover_run(m, 1);
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &ids[0], ERR));
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &ids[1], ERR));
    must(duet_motion_set_user_data(m->motion, by_ids(ids, 1), &data, ERR));
    must(duet_motion_disable_bodies(m->motion, one(5), ERR));
    must(duet_motion_remove_bodies(m->motion, one(3), ERR));
    must(duet_motion_set_targets(m->motion, one(lift), &there, ERR));
    must(duet_motion_apply_forces(m->motion, one(2), &force, ERR));
    duet_motion_def def = *duet_motion_get_def(m->motion);
    def.gravity[0] = 0.5;
    must(duet_motion_set_def(m->motion, &def, ERR));
    must(duet_motion_save(m->motion, path, ERR));
    must(duet_motion_load(fresh->motion, path, ERR));
    assert_int_equal(duet_motion_get_count(fresh->motion), 11);
    for (int k = 0; k < 3; ++k) {
        assert_true(mover_hash(m) == mover_hash(fresh));
        mover_run(m, 20);
        mover_run(fresh, 20);
    }
    assert_close(fresh->states[lift].centre[2], 4.5, 0);
    uint64_t read = 0;
    must(duet_motion_get_user_data(fresh->motion, by_ids(ids, 1), &read, ERR));
    assert_true(read == data);
    must_fail(duet_motion_wake_bodies(fresh->motion, one(3), ERR), ANY_FAILURE, "was removed");
    assert_true(duet_motion_get_def(fresh->motion)->gravity[0] == 0.5);
}
