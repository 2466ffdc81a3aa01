// SPDX-License-Identifier: MIT
// Commands to a motion: what is set, pushed or aimed at, and bodies that come and go. With
// --all random ones go to worlds of all kinds.
#include "support/mover.h"
#include "support/test.h"

#include "base/rng.h"
#include "runtime/opencl/device_pair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static duet_body_list one(uint32_t place)
{
    return (duet_body_list){.first = place, .n = 1};
}

static duet_body_list by_ids(const uint64_t *ids, uint32_t n)
{
    return (duet_body_list){.ids = ids, .n = n};
}

// Fails unless a call is refused with a line that has these words.
#define assert_refused(call, words)                       \
    do {                                                  \
        duet_error err = {0};                             \
        assert_false(call);                               \
        if (!strstr(err.text, words))                     \
            fail_msg("%s is told '%s'", #call, err.text); \
    } while (0)

#define assert_done(call)     \
    do {                      \
        duet_error err = {0}; \
        assert_ok(call, err); \
    } while (0)

// Cubes of edge 1 on a floor, that rest soon; place 0 is the floor.
static mover *make_rows(uint32_t n, uint32_t high)
{
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SLEEP | DUET_EFFECT_FORCES;
    m->def.sleep_after = 0.1;
    mover_add_floor(m, 50);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < high; ++k)
            mover_add_rough_cube(m, 3.0 * i, 0, k + 0.5);
    return m;
}

static uint32_t n_asleep(mover *m)
{
    uint32_t n = 0;
    for (uint32_t id = 0; id < duet_motion_get_count(m->motion); ++id)
        n += mover_speed(m, id) == 0.0;
    return n;
}

// ------------------------------------------------------------ what is set

static void a_field_that_is_set_is_what_the_step_begins_with(void **state)
{
    (void)state;
    mover *m = make_rows(3, 1);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 4);
    const duet_body fast = {.velocity = {1, 2, 6}, .angular_velocity = {0, 0, 3}, .mass = 9};
    assert_done(duet_motion_set_bodies(m->motion, one(2), DUET_BODY_VELOCITY, &fast, &err));
    assert_done(duet_motion_get_states(m->motion, m->states, &err));
    assert_close(m->states[2].velocity[2], 6, 0);
    assert_close(m->states[2].angular_velocity[2], 0, 0);
    mover_run(m, 1);
    assert_close(m->states[2].velocity[2], 6 - 9.81 / 60, 1e-4);
    assert_close(mover_speed(m, 1) + mover_speed(m, 3), 0, 0); // they sleep on
    duet_energy before = mover_energy(m);
    assert_done(duet_motion_set_bodies(m->motion, one(2), DUET_BODY_MASS, &fast, &err));
    assert_close(mover_energy(m).momentum[2], 9 * before.momentum[2], 1e-5);
    mover_free(m);
}

static void a_pose_that_is_set_wakes_and_falls(void **state)
{
    (void)state;
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    duet_pose high = m->poses[1];
    high.centre[2] = 10;
    high.half_extents[2] = 1;
    assert_done(duet_motion_set_poses(m->motion, one(1), &high, &err));
    mover_run(m, 1);
    assert_close(m->states[1].centre[2], 10, 0.01);
    mover_run(m, 200);
    assert_close(m->states[1].centre[2], 1, 0.01);
    mover_free(m);
}

static void wrong_commands_are_refused_by_name_and_change_nothing(void **state)
{
    (void)state;
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
    assert_refused(duet_motion_set_bodies(motion, one(1), mass, &b, &err), "mass must be 0");
    b = duet_default_body();
    b.friction = 0.5f;
    assert_refused(duet_motion_set_bodies(motion, one(1), friction, &b, &err),
                   "body 0 of 1 needs the effect friction");
    b.fixed_rotation = false;
    assert_refused(duet_motion_set_bodies(motion, one(1), DUET_BODY_FIXED_ROTATION, &b, &err),
                   "needs the effect angular_velocity");
    assert_refused(duet_motion_set_bodies(motion, one(1), 1u << 9, &b, &err), "duet_body_field");
    assert_refused(duet_motion_set_bodies(motion, one(2), mass, &b, &err), "no body 2");
    assert_refused(duet_motion_set_bodies(motion, by_ids(ids, 2), mass, &b, &err), "no body 2");
    assert_refused(duet_motion_remove_bodies(motion, by_ids(again, 2), &err), "listed twice");
    assert_refused(duet_motion_apply_forces(motion, one(1), &force, &err), "effect forces");
    assert_refused(duet_motion_sleep_bodies(motion, one(1), &err), "effect sleep");
    assert_refused(duet_motion_apply_impulses(motion, one(1), &impulse, &err), "not finite");
    assert_refused(duet_motion_set_targets(motion, one(1), &there, &err), "mass of 1");
    m->poses[1].rotation[0] = 1;
    assert_refused(duet_motion_set_poses(motion, one(1), &m->poses[1], &err), "effect rotation");
    m->poses[1].half_extents[0] = -1;
    assert_refused(duet_motion_add_bodies(motion, &m->poses[1], NULL, 1, NULL, &err),
                   "half extent is negative");
    duet_motion_def def = *duet_motion_get_def(motion);
    def.dt = 1;
    assert_refused(duet_motion_set_def(motion, &def, &err), "dt is 1; expected the motion's");
    def = *duet_motion_get_def(motion);
    def.drag = 1;
    assert_refused(duet_motion_set_def(motion, &def, &err), "effect drag");
    assert_true(mover_hash(m) == hash);
    mover_run(m, 1);
    mover_free(m);
}

static void gravity_can_change_while_all_sleep(void **state)
{
    (void)state;
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 3);
    duet_motion_def def = *duet_motion_get_def(m->motion);
    def.gravity[2] = 3;
    assert_done(duet_motion_set_def(m->motion, &def, &err));
    mover_run(m, 60);
    assert_close(m->states[1].velocity[2], 3, 0.05);
    mover_free(m);
}

// ------------------------------------------------------------ what pushes

static void a_force_holds_for_one_step_and_can_carry_a_weight(void **state)
{
    (void)state;
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
                assert_done(duet_motion_apply_forces(m->motion, one(id), &lift, &err));
                mover_run(m, 1);
            }
            double inertia = 2.0 / 3 * (0.25 + 0.25);
            assert_close(m->states[id].centre[2], 5, 1e-5);
            assert_close(m->states[id].angular_velocity[1], 1 / inertia, 1e-4);
            mover_run(m, 60);
            assert_close(m->states[id].velocity[2], -10, 1e-4);
            mover_free(m);
        }
}

static void an_impulse_beside_the_centre_turns(void **state)
{
    (void)state;
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_ANGULAR_VELOCITY;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 2);
    mover_turn(m, id, 1, 2, 3, 0.7);
    m->bodies[id].mass = 3;
    mover_run(m, 0);
    const duet_impulse hit = {.impulse = {0, 6, 0}, .anchor = {0.5f, 0, 0}};
    assert_done(duet_motion_apply_impulses(m->motion, one(id), &hit, &err));
    mover_run(m, 1);
    assert_close(m->states[id].velocity[1], 2, 1e-6);
    assert_close(m->states[id].angular_velocity[2], 0.5 * 6 / 2, 1e-6); // a cube: m/6 edge^2
    mover_free(m);
}

// ------------------------------------------------------------ kinematic bodies

static void a_target_is_reached_exactly_and_carries_what_lies_on_it(void **state)
{
    (void)state;
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.sleep_after = 0.1;
    mover_add_floor(m, 20);
    uint32_t lift = mover_add(m, 0, 0, 1, 2, 2, 0.25);
    m->bodies[lift].mass = 0;
    m->bodies[lift].friction = 0.6f;
    uint32_t load = mover_add_rough_cube(m, 0, 0, 1.75);
    mover_run(m, 60);
    assert_close(mover_speed(m, load), 0, 0);
    for (int step = 1; step <= 120; ++step) {
        float angle = 0.5f * (float)step / 120;
        const duet_transform there = {{(float)step / 100, 0, 1 + (float)step / 60},
                                      {0, 0, sinf(angle / 2), cosf(angle / 2)}};
        assert_done(duet_motion_set_targets(m->motion, one(lift), &there, &err));
        assert_done(duet_motion_get_states(m->motion, m->states, &err));
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
    mover_free(m);
}

static void what_has_no_mass_and_moves_wakes_what_it_newly_reaches(void **state)
{
    (void)state;
    mover *m = make_rows(2, 1);
    uint32_t ram = mover_add_cube(m, -3, 0, 0.6, 1);
    m->bodies[ram].mass = 0;
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 4);
    const duet_body pushes = {.velocity = {2, 0, 0}};
    assert_done(duet_motion_set_bodies(m->motion, one(ram), DUET_BODY_VELOCITY, &pushes, &err));
    mover_run(m, 90); // 2 m to the first cube, and then 1 m with it
    assert_close(m->states[1].centre[0], 1, 0.05);
    mover_free(m);
}

static void a_target_wakes_what_it_reaches_in_one_step(void **state)
{
    (void)state;
    mover *m = make_rows(1, 1);
    uint32_t ram = mover_add_cube(m, 8, 0, 0.6, 1);
    m->bodies[ram].mass = 0;
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 3);
    const duet_transform there = {{0.8f, 0, 0.6f}, {0, 0, 0, 1}};
    assert_done(duet_motion_set_targets(m->motion, one(ram), &there, &err));
    mover_run(m, 30);
    assert_true(m->states[1].centre[0] < -0.1); // pushed out
    mover_free(m);
}

static void what_has_no_mass_and_is_put_elsewhere_wakes_its_neighbours(void **state)
{
    (void)state;
    mover *m = make_rows(2, 1);
    uint32_t shelf = mover_add(m, 20, 0, 3, 1, 1, 0.25);
    m->bodies[shelf].mass = 0;
    uint32_t book = mover_add_rough_cube(m, 20, 0, 3.75);
    mover_run(m, 60);
    assert_int_equal(n_asleep(m), 5);
    duet_pose away = m->poses[shelf];
    away.centre[0] = 0.9f; // into the first cube
    away.centre[2] = 0.25f;
    assert_done(duet_motion_set_poses(m->motion, one(shelf), &away, &err));
    mover_run(m, 30);
    assert_true(m->states[book].centre[2] < 3); // nothing holds it
    assert_true(m->states[1].centre[2] > 0.6);  // pushed out
    mover_free(m);
}

// ------------------------------------------------------------ bodies that come and go

static void ids_are_handles_and_places_are_used_again(void **state)
{
    (void)state;
    mover *m = make_rows(4, 1);
    mover_run(m, 1);
    duet_motion *motion = m->motion;
    const uint64_t going[2] = {3, 1};
    uint64_t ids[5] = {0};
    assert_done(duet_motion_remove_bodies(motion, by_ids(going, 2), &err));
    assert_false(duet_motion_has_body(motion, 1));
    assert_true(duet_motion_has_body(motion, 2));
    assert_refused(duet_motion_wake_bodies(motion, by_ids(going, 1), &err), "id 3 was removed");
    assert_refused(duet_motion_wake_bodies(motion, one(1), &err), "was removed");
    const duet_pose pose = {{-5, 0, 5}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_pose poses[3] = {pose, pose, pose};
    assert_done(duet_motion_add_bodies(motion, poses, NULL, 1, ids, &err));
    assert_true(ids[0] == 5); // the places that were left are empty after the step
    mover_run(m, 1);
    assert_done(duet_motion_add_bodies(motion, poses, NULL, 3, ids, &err));
    const uint64_t second = UINT64_C(1) << 32;
    assert_true(ids[0] == (second | 1) && ids[1] == (second | 3) && ids[2] == 6);
    assert_refused(duet_motion_wake_bodies(motion, by_ids(going, 1), &err), "id 3 was removed");
    assert_true(duet_motion_has_body(motion, ids[1]));
    assert_done(duet_motion_remove_bodies(motion, by_ids(ids, 1), &err));
    assert_done(duet_motion_get_ids(motion, 0, 5, ids, &err));
    assert_true(ids[0] == 0 && ids[1] == DUET_NO_BODY && ids[3] == (second | 3) && ids[4] == 4);
    const uint64_t data[2] = {77, UINT64_MAX};
    uint64_t read[2] = {0};
    const duet_body_list two = {.first = 2, .n = 2};
    assert_done(duet_motion_set_user_data(motion, two, data, &err));
    assert_done(duet_motion_get_user_data(motion, two, read, &err));
    assert_memory_equal(read, data, sizeof data);
    mover_free(m);
}

static void what_lay_on_a_removed_body_falls(void **state)
{
    (void)state;
    for (int disabled = 0; disabled < 2; ++disabled) {
        mover *m = make_rows(2, 3);
        m->def.skin = disabled ? 0.2 : 0;
        mover_run(m, 60);
        assert_int_equal(n_asleep(m), 7);
        if (disabled)
            assert_done(duet_motion_disable_bodies(m->motion, one(1), &err));
        else
            assert_done(duet_motion_remove_bodies(m->motion, one(1), &err));
        mover_run(m, 1);
        mover_run(m, 1);
        assert_true(m->states[2].velocity[2] < -0.1);
        assert_close(mover_speed(m, 4) + mover_speed(m, 5) + mover_speed(m, 6), 0, 0);
        mover_run(m, 120);
        assert_close(m->states[2].centre[2], 0.5, 0.02);
        assert_close(m->states[3].centre[2], 1.5, 0.02);
        if (disabled) { // it comes back inside another, and both part
            assert_close(m->states[1].centre[2], 0.5, 0.02);
            assert_done(duet_motion_enable_bodies(m->motion, one(1), &err));
            mover_run(m, 120);
            assert_true(fabs(m->states[2].centre[2] - m->states[1].centre[2]) > 0.9 ||
                        fabs(m->states[2].centre[0] - m->states[1].centre[0]) > 0.9 ||
                        fabs(m->states[2].centre[1] - m->states[1].centre[1]) > 0.9);
        }
        mover_assert_finite(m);
        mover_free(m);
    }
}

static void a_body_that_comes_falls_as_one_that_was_there(void **state)
{
    (void)state;
    duet_state states[2][8];
    for (int late = 0; late < 2; ++late) {
        mover *m = make_rows(2, 1);
        m->def.boundary = DUET_BOUNDARY_WALLS;
        for (int k = 0; k < 3; ++k) {
            m->def.lower[k] = -0.5;
            m->def.upper[k] = 8;
        }
        const duet_pose pose = {{6, 3, 2}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
        duet_body b = duet_default_body();
        b.friction = 0.6f;
        if (!late) {
            uint32_t id = mover_add_cube(m, 6, 3, 2, 1);
            m->bodies[id] = b;
        }
        mover_run(m, 0);
        if (late)
            assert_done(duet_motion_add_bodies(m->motion, &pose, &b, 1, NULL, &err));
        m->n = 4;
        mover_run(m, 90);
        memcpy(states[late], m->states, sizeof states[late]);
        mover_free(m);
    }
    assert_memory_equal(states[0], states[1], 4 * sizeof states[0][0]);
}

static void a_motion_can_begin_empty(void **state)
{
    (void)state;
    mover *m = mover_new(3);
    m->def.gravity[2] = -10;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_GRAVITY | DUET_EFFECT_FRICTION |
                   DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_SLEEP;
    mover_run(m, 2);
    uint32_t floor = mover_add_floor(m, 5), brick = mover_add(m, 0, 0, 2, 0.5, 0.25, 0.125);
    mover_turn(m, brick, 1, 1, 0, 0.5);
    m->bodies[brick].friction = 0.5f;
    assert_done(duet_motion_add_bodies(m->motion, m->poses, m->bodies, 2, NULL, &err));
    mover_run(m, 300);
    assert_close(m->states[floor].centre[2], -0.5, 0);
    assert_close(m->states[brick].centre[2], 0.125, 0.01);
    assert_close(mover_speed(m, brick), 0, 0);
    mover_free(m);
}

static void a_floor_can_get_a_mass(void **state)
{
    (void)state;
    mover *m = make_rows(4, 2);
    uint32_t plate = mover_add(m, 0, 20, 10, 3, 3, 0.25);
    m->bodies[plate].mass = 0;
    for (int i = 0; i < 9; ++i)
        mover_add_rough_cube(m, 1.5 * (i % 3) - 1.5, 20 + 1.5 * (i / 3) - 1.5, 10.75);
    mover_run(m, 60);
    const duet_body heavy = {.mass = 50};
    assert_done(duet_motion_set_bodies(m->motion, one(plate), DUET_BODY_MASS, &heavy, &err));
    mover_run(m, 240);
    assert_close(m->states[plate].centre[2], 0.25, 0.02);
    for (uint32_t id = plate + 1; id < m->n; ++id)
        assert_close(m->states[id].centre[2], 1, 0.05);
    mover_free(m);
}

// Whether a search dropped what it touched before or kept it within its skin is the same.
static void what_is_sent_to_sleep_in_flight_does_not_depend_on_the_skin(void **state)
{
    (void)state;
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
            assert_done(duet_motion_sleep_bodies(m->motion, one(i), &err));
        }
        mover_run(m, 10);
        hashes[k] = mover_hash(m);
        mover_free(m);
    }
    assert_true(hashes[0] == hashes[1]);
}

// ------------------------------------------------------------ files

static void name_file(char path[64])
{
    snprintf(path, 64, "/tmp/duet-commands-%ld", (long)getpid());
}

static void a_file_of_the_last_version_still_loads(void **state)
{
    (void)state;
    char path[1024];
    snprintf(path, sizeof path, "%s/motion_v2.duet", getenv("DUET_TEST_DATA"));
    mover *m = mover_new(3);
    m->def.gravity[2] = -9.81;
    m->def.wants = DUET_EFFECT_SLEEP;
    mover_add_floor(m, 5);
    for (int i = 1; i < 9; ++i)
        mover_add_rough_cube(m, 0.1f * (float)i, 0.0625f * (float)i, 1.25f * (float)i);
    uint64_t loaded[2], later[2];
    for (int commanded = 0; commanded < 2; ++commanded) {
        mover_run(m, 3);
        if (commanded) { // the motion is then as it was made
            assert_done(duet_motion_remove_bodies(m->motion, one(4), &err));
            assert_done(duet_motion_add_bodies(m->motion, m->poses, NULL, 2, NULL, &err));
        }
        assert_done(duet_motion_load(m->motion, path, &err));
        assert_int_equal(duet_motion_get_count(m->motion), 9);
        loaded[commanded] = mover_hash(m);
        mover_run(m, 10);
        assert_int_equal(m->last.step, 100);
        later[commanded] = mover_hash(m);
    }
    assert_true(loaded[0] == loaded[1] && later[0] == later[1] && loaded[0] != later[0]);
    mover_free(m);
}

static void what_commands_left_is_saved(void **state)
{
    (void)state;
    char path[64];
    name_file(path);
    mover *m = make_rows(4, 2), *fresh = make_rows(4, 2);
    uint32_t lift = mover_add(m, 3, 0, 5, 0.5, 0.5, 0.5);
    m->bodies[lift].mass = 0;
    mover_add(fresh, 3, 0, 5, 0.5, 0.5, 0.5);
    fresh->bodies[lift].mass = 0;
    mover_run(m, 10);
    mover_run(fresh, 3);
    const uint64_t data = 12345;
    const duet_transform there = {{3, 0, 4.5f}, {0, 0, 0, 1}};
    const duet_force force = {.force = {0, 0, 100}};
    const duet_pose pose = {{-4, 0, 5}, {0.5f, 0.25f, 0.5f}, {0, 0, 0, 1}};
    uint64_t ids[2];
    assert_done(duet_motion_remove_bodies(m->motion, one(1), &err));
    mover_run(m, 1);
    assert_done(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &ids[0], &err));
    assert_done(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &ids[1], &err));
    assert_done(duet_motion_set_user_data(m->motion, by_ids(ids, 1), &data, &err));
    assert_done(duet_motion_disable_bodies(m->motion, one(5), &err));
    assert_done(duet_motion_remove_bodies(m->motion, one(3), &err));
    assert_done(duet_motion_set_targets(m->motion, one(lift), &there, &err));
    assert_done(duet_motion_apply_forces(m->motion, one(2), &force, &err));
    duet_motion_def def = *duet_motion_get_def(m->motion);
    def.gravity[0] = 0.5;
    assert_done(duet_motion_set_def(m->motion, &def, &err));
    assert_done(duet_motion_save(m->motion, path, &err));
    assert_done(duet_motion_load(fresh->motion, path, &err));
    assert_int_equal(duet_motion_get_count(fresh->motion), 11);
    for (int k = 0; k < 3; ++k) {
        assert_true(mover_hash(m) == mover_hash(fresh));
        mover_run(m, 20);
        mover_run(fresh, 20);
    }
    assert_close(fresh->states[lift].centre[2], 4.5, 0);
    uint64_t read = 0;
    assert_done(duet_motion_get_user_data(fresh->motion, by_ids(ids, 1), &read, &err));
    assert_true(read == data);
    assert_refused(duet_motion_wake_bodies(fresh->motion, one(3), &err), "was removed");
    assert_true(duet_motion_get_def(fresh->motion)->gravity[0] == 0.5);
    remove(path);
    mover_free(m);
    mover_free(fresh);
}

// ------------------------------------------------------------ the same everywhere

enum { PLAYERS = 5, MOST_IDS = 4096 };

static int n_fuzzed_steps = 200, n_worlds = 1;

// Worlds that kernels and buffers differ in.
typedef enum world_kind { USUAL, FLAT, DOUBLES, PLACED, FLIGHT, WORLD_KINDS } world_kind;

// One stream of commands goes to motions with several plans.
typedef struct play {
    world_kind kind;
    rng r;
    mover *movers[PLAYERS];
    uint64_t ids[MOST_IDS], stale[MOST_IDS];
    uint32_t n_ids, n_stale;
    char path[64];
} play;

static float between(play *p, double from, double to)
{
    return (float)rng_between(&p->r, from, to);
}

static duet_pose random_pose(play *p)
{
    duet_pose pose = {.rotation = {between(p, -1, 1), between(p, -1, 1), between(p, -1, 1), 1}};
    if (p->kind == FLAT)
        pose.rotation[0] = pose.rotation[1] = 0;
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = between(p, 0.5, k == 2 ? 12 : 11.5);
        pose.half_extents[k] = between(p, 0.1, 0.4);
    }
    return pose;
}

static duet_body random_body(play *p)
{
    duet_body b = duet_default_body();
    for (int k = 0; k < 3; ++k) {
        b.velocity[k] = between(p, -3, 3);
        b.angular_velocity[k] = between(p, -3, 3);
    }
    b.mass = rng_below(&p->r, 8) ? between(p, 0.5, 3) : 0;
    if (b.mass == 0 && rng_below(&p->r, 2))
        memset(b.velocity, 0, sizeof b.velocity);
    if (p->kind == FLIGHT)
        return b;
    b.friction = between(p, 0, 1);
    b.restitution = between(p, 0, 0.5);
    b.group = 1u << rng_below(&p->r, 3);
    return b;
}

enum { MOST_AT_ONCE = 12 };

// What one command is given.
typedef struct order {
    uint32_t n;
    uint64_t ids[MOST_AT_ONCE];
    duet_pose poses[MOST_AT_ONCE];
    duet_body bodies[MOST_AT_ONCE];
    duet_force forces[MOST_AT_ONCE];
    duet_impulse impulses[MOST_AT_ONCE];
    duet_transform targets[MOST_AT_ONCE];
    uint32_t fields;
    duet_motion_def def;
} order;

static order random_order(play *p)
{
    order o = {.n = 1 + rng_below(&p->r, MOST_AT_ONCE), .fields = rng_below(&p->r, DUET_BODY_ALL)};
    o.n = o.n < p->n_ids ? o.n : p->n_ids;
    uint32_t at = rng_below(&p->r, p->n_ids);
    for (uint32_t i = 0; i < o.n; ++i) {
        o.ids[i] = p->ids[(at + 7 * i) % p->n_ids];
        o.poses[i] = random_pose(p);
        o.bodies[i] = random_body(p);
        for (int k = 0; k < 3; ++k) {
            o.forces[i].force[k] = between(p, -30, 30);
            o.forces[i].torque[k] = between(p, -3, 3);
            o.impulses[i].impulse[k] = between(p, -2, 2);
            o.impulses[i].anchor[k] = between(p, -0.3, 0.3);
            o.targets[i].centre[k] = o.poses[i].centre[k];
        }
        memcpy(o.targets[i].rotation, o.poses[i].rotation, sizeof o.targets[i].rotation);
    }
    o.def = *duet_motion_get_def(p->movers[0]->motion);
    o.def.gravity[rng_below(&p->r, 3)] = between(p, -10, 2);
    return o;
}

// Each id once.
static void without_twins(order *o)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < o->n; ++i) {
        bool seen = false;
        for (uint32_t k = 0; k < n; ++k)
            seen |= o->ids[k] == o->ids[i];
        if (!seen)
            o->ids[n++] = o->ids[i];
    }
    o->n = n;
}

static void forget_ids(play *p, const order *o)
{
    for (uint32_t i = 0; i < o->n; ++i) {
        uint32_t at = 0;
        while (p->ids[at] != o->ids[i])
            ++at;
        p->ids[at] = p->ids[--p->n_ids];
        p->stale[p->n_stale++ % MOST_IDS] = o->ids[i];
    }
}

typedef enum verb {
    ADD,
    REMOVE,
    SET,
    SET_POSES,
    FORCE,
    IMPULSE,
    AIM,
    DISABLE,
    ENABLE,
    PUT_TO_SLEEP,
    WAKE,
    CHANGE,
    VERBS
} verb;

// Some are refused, such as a target for what has a mass: by all alike.
static bool obey(verb what, duet_motion *m, const order *o, uint64_t *came, duet_error *err)
{
    const duet_body_list list = by_ids(o->ids, o->n);
    switch (what) {
    case ADD:
        return duet_motion_add_bodies(m, o->poses, o->bodies, o->n, came, err);
    case REMOVE:
        return duet_motion_remove_bodies(m, list, err);
    case SET:
        return duet_motion_set_bodies(m, list, o->fields, o->bodies, err);
    case SET_POSES:
        return duet_motion_set_poses(m, list, o->poses, err);
    case FORCE:
        return duet_motion_apply_forces(m, list, o->forces, err);
    case IMPULSE:
        return duet_motion_apply_impulses(m, list, o->impulses, err);
    case AIM:
        return duet_motion_set_targets(m, by_ids(o->ids, 1), o->targets, err);
    case DISABLE:
        return duet_motion_disable_bodies(m, list, err);
    case ENABLE:
        return duet_motion_enable_bodies(m, list, err);
    case PUT_TO_SLEEP:
        return duet_motion_sleep_bodies(m, list, err);
    case WAKE:
        return duet_motion_wake_bodies(m, list, err);
    default:
        return duet_motion_set_def(m, &o->def, err);
    }
}

// True where all the players did it.
static bool command_all(play *p, verb what, order *o)
{
    uint64_t came[PLAYERS][MOST_AT_ONCE] = {{0}};
    duet_error errs[PLAYERS] = {{0}};
    bool first = false;
    for (int k = 0; k < PLAYERS; ++k) {
        duet_motion *m = p->movers[k]->motion;
        o->def.plan = duet_motion_get_def(m)->plan;
        o->def.skin = duet_motion_get_def(m)->skin;
        bool ok = obey(what, m, o, came[k], &errs[k]);
        first = k == 0 ? ok : first;
        if (ok != first || strcmp(errs[k].text, errs[0].text) != 0)
            fail_msg("command %d: player %d is told '%s', the first '%s'", what, k, errs[k].text,
                     errs[0].text);
        assert_memory_equal(came[k], came[0], sizeof came[0]);
    }
    if (!first && !strstr(errs[0].text, "mass of") && !strstr(errs[0].text, "is disabled"))
        fail_msg("command %d: %s", what, errs[0].text);
    if (first && what == ADD)
        for (uint32_t i = 0; i < o->n; ++i)
            p->ids[p->n_ids++] = came[0][i];
    return first;
}

static void command_once(play *p)
{
    verb what = (verb)rng_below(&p->r, VERBS);
    if (p->kind == FLIGHT && (what == WAKE || what == PUT_TO_SLEEP))
        return;
    order o = random_order(p);
    if ((what == ADD && p->n_ids > 320) || (what == REMOVE && p->n_ids < 160) ||
        (what == CHANGE && rng_below(&p->r, 4)))
        return;
    without_twins(&o);
    if (command_all(p, what, &o) && what == REMOVE)
        forget_ids(p, &o);
}

static void assert_stale_ids_are_refused(play *p)
{
    if (p->n_stale == 0)
        return;
    uint32_t n = p->n_stale < MOST_IDS ? p->n_stale : MOST_IDS;
    const uint64_t id = p->stale[rng_below(&p->r, n)];
    assert_refused(duet_motion_remove_bodies(p->movers[0]->motion, by_ids(&id, 1), &err),
                   "was removed");
}

// What one player saved another goes on with, perhaps as one that is new. Rows are those of
// a skin.
static void save_and_load(play *p)
{
    uint32_t from = rng_below(&p->r, PLAYERS), to = rng_below(&p->r, PLAYERS);
    to = p->movers[from]->def.skin == p->movers[to]->def.skin ? to : from;
    assert_done(duet_motion_save(p->movers[from]->motion, p->path, &err));
    if (rng_below(&p->r, 2)) {
        mover_restart(p->movers[to]);
        mover_run(p->movers[to], 0);
    }
    assert_done(duet_motion_load(p->movers[to]->motion, p->path, &err));
}

static void assert_all_are_equal(play *p, int step)
{
    uint64_t hash = mover_hash(p->movers[0]);
    for (int k = 1; k < PLAYERS; ++k)
        if (mover_hash(p->movers[k]) != hash)
            fail_msg("player %d differs after step %d", k, step);
}

static void set_world(mover *m, world_kind kind)
{
    duet_motion_def *d = &m->def;
    d->wants = DUET_EFFECT_FORCES | DUET_EFFECT_SLEEP | DUET_EFFECT_FILTER | DUET_EFFECT_EVENTS;
    d->sleep_after = 0.1;
    d->gravity[kind == FLAT ? 1 : 2] = -9.81;
    d->doubles = kind == DOUBLES || kind == FLIGHT;
    d->origin_edge = kind == PLACED ? 4 : 0;
    d->boundary = kind == PLACED ? DUET_BOUNDARY_NONE : DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k)
        d->upper[k] = k == (kind == FLAT ? 1 : 2) ? 40 : 12;
    if (kind != FLIGHT)
        return;
    d->wants = DUET_EFFECT_FORCES;
    d->boundary = DUET_BOUNDARY_PERIODIC;
    d->integrator = DUET_INTEGRATOR_VERLET;
    d->skin = 0;
}

static play begin_play(world_kind kind, uint64_t seed)
{
    static const struct {
        uint32_t share;
        duet_mode mode;
        double skin;
    } ways[PLAYERS] = {
        {0, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE / 3, DUET_MODE_SHARED, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_SLAB, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_OWN, 0.2},
    };
    play p = {.kind = kind, .r = rng_seed(seed), .n_ids = 200};
    name_file(p.path);
    for (int k = 0; k < PLAYERS; ++k) {
        mover *m = p.movers[k] = mover_new(kind == FLAT ? 2 : 3);
        m->def.plan.share = ways[k].share;
        m->def.plan.mode = ways[k].mode;
        m->def.skin = ways[k].skin;
        set_world(m, p.kind);
        m->n = 200;
        rng r = p.r;
        for (uint32_t i = 0; i < m->n; ++i) {
            m->poses[i] = random_pose(&p);
            m->bodies[i] = random_body(&p);
        }
        if (k + 1 < PLAYERS)
            p.r = r;
        mover_run(m, 0);
    }
    for (uint32_t i = 0; i < p.n_ids; ++i)
        p.ids[i] = i;
    return p;
}

// The state's hash at the end.
static uint64_t play_once(world_kind kind, int n_steps, uint64_t seed)
{
    play p = begin_play(kind, seed);
    for (int step = 0; step < n_steps; ++step) {
        for (uint32_t n = rng_below(&p.r, 4); n > 0; --n)
            command_once(&p);
        assert_stale_ids_are_refused(&p);
        if (rng_below(&p.r, 16) == 0)
            save_and_load(&p);
        duet_error err = {0};
        for (int k = 0; k < PLAYERS; ++k)
            assert_ok(duet_motion_advance(p.movers[k]->motion, &p.movers[k]->last, &err), err);
        if (step % 5 == 0 || step + 1 == n_steps)
            assert_all_are_equal(&p, step);
    }
    print_message("world %d: %u bodies, %u places, %u stale ids\n", kind, p.n_ids,
                  duet_motion_get_count(p.movers[0]->motion), p.n_stale);
    uint64_t hash = mover_hash(p.movers[0]);
    for (int k = 0; k < PLAYERS; ++k)
        mover_free(p.movers[k]);
    remove(p.path);
    return hash;
}

static void the_same_commands_give_the_same_bits(void **state)
{
    (void)state;
    uint64_t seed = test_seed();
    print_message("DUET_TEST_SEED=%llu\n", (unsigned long long)seed);
    for (int kind = 0; kind < n_worlds; ++kind)
        play_once((world_kind)kind, n_fuzzed_steps, seed + (uint64_t)kind);
}

static void set_host_memory(bool host)
{
    for (int side = 0; side < 2; ++side)
        mover_pair()->devices[side].info.host_memory = host;
}

// Rows are then fetched, changed and sent back.
static void devices_with_memory_of_their_own_give_the_same_bits(void **state)
{
    (void)state;
    uint64_t seed = test_seed();
    bool host = mover_pair()->devices[1].info.host_memory;
    uint64_t hash = play_once(USUAL, 60, seed);
    set_host_memory(false);
    assert_true(play_once(USUAL, 60, seed) == hash);
    set_host_memory(host);
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--all") == 0) {
        n_fuzzed_steps = 500;
        n_worlds = WORLD_KINDS;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_field_that_is_set_is_what_the_step_begins_with),
        cmocka_unit_test(a_pose_that_is_set_wakes_and_falls),
        cmocka_unit_test(wrong_commands_are_refused_by_name_and_change_nothing),
        cmocka_unit_test(gravity_can_change_while_all_sleep),
        cmocka_unit_test(a_force_holds_for_one_step_and_can_carry_a_weight),
        cmocka_unit_test(an_impulse_beside_the_centre_turns),
        cmocka_unit_test(a_target_is_reached_exactly_and_carries_what_lies_on_it),
        cmocka_unit_test(what_has_no_mass_and_moves_wakes_what_it_newly_reaches),
        cmocka_unit_test(a_target_wakes_what_it_reaches_in_one_step),
        cmocka_unit_test(what_has_no_mass_and_is_put_elsewhere_wakes_its_neighbours),
        cmocka_unit_test(ids_are_handles_and_places_are_used_again),
        cmocka_unit_test(what_lay_on_a_removed_body_falls),
        cmocka_unit_test(a_body_that_comes_falls_as_one_that_was_there),
        cmocka_unit_test(a_motion_can_begin_empty),
        cmocka_unit_test(a_floor_can_get_a_mass),
        cmocka_unit_test(what_is_sent_to_sleep_in_flight_does_not_depend_on_the_skin),
        cmocka_unit_test(a_file_of_the_last_version_still_loads),
        cmocka_unit_test(what_commands_left_is_saved),
        cmocka_unit_test(the_same_commands_give_the_same_bits),
        cmocka_unit_test(devices_with_memory_of_their_own_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, mover_open_pair, mover_close_pair);
}
