// SPDX-License-Identifier: MIT
// The def for an ordinary game: a motion that begins empty takes all that a game brings later.
#include "support/test.h"

#include "support/devices.h"

enum { FLOOR, BOX, SLIDER, SENSOR, GHOST, WALL, BULLET, LIFTED, BODIES };

// The axis that is up, and one beside it.
typedef struct axes {
    int up, along;
} axes;

static duet_pose pose_at(axes a, float along, float up, float wide, float high)
{
    duet_pose pose = {{0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    pose.centre[a.along] = along;
    pose.centre[a.up] = up;
    pose.half_extents[a.along] = wide;
    pose.half_extents[a.up] = high;
    return pose;
}

// A floor, a box that falls on it, one that slides, a sensor in its way, one that touches nothing,
// a thin wall, a bullet at it, and a box that a force carries.
static void add_bodies(duet_motion *motion, axes a, uint64_t ids[BODIES])
{
    const duet_pose poses[BODIES] = {
        [FLOOR] = pose_at(a, 0, -0.5f, 50, 0.5f),    [BOX] = pose_at(a, 0, 2, 0.5f, 0.5f),
        [SLIDER] = pose_at(a, 10, 0.5f, 0.5f, 0.5f), [SENSOR] = pose_at(a, 12, 1, 0.25f, 0.5f),
        [GHOST] = pose_at(a, -5, 2, 0.5f, 0.5f),     [WALL] = pose_at(a, -20, 1, 0.05f, 1),
        [BULLET] = pose_at(a, -30, 1, 0.1f, 0.1f),   [LIFTED] = pose_at(a, -12, 3, 0.5f, 0.5f),
    };
    duet_body bodies[BODIES];
    for (int i = 0; i < BODIES; ++i) {
        bodies[i] = duet_default_body();
        bodies[i].friction = 0.5f;
    }
    bodies[FLOOR].mass = bodies[SENSOR].mass = bodies[WALL].mass = 0;
    bodies[SENSOR].sensor = true;
    bodies[GHOST].mask = 0;
    bodies[SLIDER].velocity[a.along] = 4;
    bodies[BULLET].velocity[a.along] = 300;
    must(duet_motion_add_bodies(motion, poses, bodies, BODIES, ids, ERR));
}

static bool sees(const duet_motion_result *result, uint32_t a, uint32_t b)
{
    for (uint64_t i = 0; i < result->n_events; ++i)
        if (result->events[i].begins && result->events[i].a == a && result->events[i].b == b)
            return true;
    return false;
}

static void play(uint32_t dims)
{
    const axes a = {dims == 2 ? 1 : 2, 0};
    duet_motion_def def = duet_game_motion_def(default_pair(), dims);
    duet_motion *motion = kept(duet_motion_create(&def, NULL, NULL, 0, ERR));
    uint64_t ids[BODIES];
    bool sensed = false;
    add_bodies(motion, a, ids);
    duet_state states[BODIES];
    duet_motion_result result;
    duet_force lift = {.force = {0}};
    lift.force[a.up] = 9.81f;
    for (int step = 0; step < 180; ++step) {
        const duet_body_list lifted = {&ids[LIFTED], 0, 1};
        must(duet_motion_apply_forces(motion, lifted, &lift, ERR));
        must(duet_motion_advance(motion, &result, ERR));
        sensed = sensed || sees(&result, SLIDER, SENSOR);
    }
    must(duet_motion_get_states(motion, states, ERR));
    assert_float_equal(states[BOX].centre[a.up], 0.5, 0.02);
    assert_float_equal(states[SLIDER].centre[a.along], 10 + 4 * 4 / (2 * 0.5 * 9.81), 0.1);
    assert_true(sensed);
    assert_true(states[GHOST].centre[a.up] < -30);
    assert_true(states[BULLET].centre[a.along] < -20);
    assert_float_equal(states[LIFTED].centre[a.up], 3, 0.01);
    for (int i = 0; i < 240; ++i)
        must(duet_motion_advance(motion, &result, ERR));
    must(duet_motion_get_states(motion, states, ERR));
    for (int k = 0; k < 3; ++k) // asleep
        assert_true(states[BOX].velocity[k] == 0 && states[SLIDER].velocity[k] == 0);
}

TEST(a_game_begins_empty_and_takes_what_comes)
{
    play(3);
    play(2);
}
