// SPDX-License-Identifier: MIT
// A cube falls onto a floor: a motion moves bodies and lets them push each other.
#include <duet/duet.h>

#include <stdio.h>

int main(void)
{
    const duet_pose poses[] = {
        {{0, 0, 2}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}}, // a cube
        {{0, 0, -1}, {5, 5, 1}, {0, 0, 0, 1}},         // above a floor
    };
    duet_body bodies[] = {duet_default_body(), duet_default_body()};
    bodies[1].mass = 0; // nothing moves the floor
    duet_error err = {0};
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&devices, &err);
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    def.gravity[2] = -10;
    duet_motion *motion = pair ? duet_motion_create(&def, poses, bodies, 2, &err) : NULL;
    duet_motion_result result;
    duet_state states[2];
    bool ok = motion != NULL;
    for (int step = 0; ok && step < 60; ++step)
        ok = duet_motion_advance(motion, &result, &err);
    ok = ok && duet_motion_get_states(motion, states, &err);
    if (ok)
        printf("after %.2f s the cube is at height %.2f\n", result.time, states[0].centre[2]);
    else
        fprintf(stderr, "%s\n", err.text);
    duet_motion_destroy(motion);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
