// SPDX-License-Identifier: MIT
// A crane: a fork without mass gets a pose for each step. It lifts a crate, carries it
// aside and turns it, and the crate feels how the fork moves.
#include <duet/duet.h>

#include <math.h>
#include <stdio.h>

enum { GROUND, FORK, CRATE, BODIES, STEPS = 300 };

// From 0 to 1 between two times, without a jerk at either.
static float ease(int step, int from, int to)
{
    float t = (float)(step - from) / (float)(to - from);
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3 - 2 * t);
}

static duet_transform fork_at(int step)
{
    float up = 2 * ease(step, 0, 100), aside = 3 * ease(step, 100, 200);
    float half_turn = 0.785398f * ease(step, 200, 300); // parts of a quarter turn
    const duet_transform at = {{aside, 0, 0.1f + up}, {0, 0, sinf(half_turn), cosf(half_turn)}};
    return at;
}

static bool carry(duet_motion *motion, duet_error *err)
{
    const duet_body_list fork = {NULL, FORK, 1};
    duet_motion_result result;
    bool ok = true;
    for (int step = 1; ok && step <= STEPS; ++step) {
        const duet_transform target = fork_at(step);
        ok = duet_motion_set_targets(motion, fork, &target, err) &&
             duet_motion_advance(motion, &result, err);
    }
    return ok;
}

int main(void)
{
    const duet_pose poses[BODIES] = {
        {{0, 0, -0.5f}, {10, 10, 0.5f}, {0, 0, 0, 1}},
        {{0, 0, 0.1f}, {0.8f, 0.8f, 0.1f}, {0, 0, 0, 1}},
        {{0, 0, 0.7f}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}},
    };
    duet_body bodies[BODIES];
    duet_state states[BODIES];
    for (int i = 0; i < BODIES; ++i) {
        bodies[i] = duet_default_body();
        bodies[i].friction = 0.8f;
    }
    bodies[GROUND].mass = bodies[FORK].mass = 0;
    duet_error err = {0};
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&devices, &err);
    duet_motion_def def = duet_game_motion_def(pair, 3); // z is up
    duet_motion *motion = pair ? duet_motion_create(&def, poses, bodies, BODIES, &err) : NULL;
    bool ok = motion && carry(motion, &err) && duet_motion_get_states(motion, states, &err);
    if (ok)
        printf("the fork is at %.2f %.2f, and the crate on it at %.1f %.1f\n",
               states[FORK].centre[0], states[FORK].centre[2], states[CRATE].centre[0],
               states[CRATE].centre[2]);
    else
        fprintf(stderr, "%s\n", err.text);
    duet_motion_destroy(motion);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
