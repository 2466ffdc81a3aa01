// SPDX-License-Identifier: MIT
// Counts hits: ten cubes fall onto a floor and bounce. Each step's result has the impacts
// above a speed, with the point, the normal, the speed and the impulse of each.
#include <duet/duet.h>

#include <stdio.h>

enum { CUBES = 10, STEPS = 300 };

int main(void)
{
    duet_pose poses[CUBES + 1] = {{{0, 0, -1}, {20, 20, 1}, {0, 0, 0, 1}}}; // the floor
    duet_body bodies[CUBES + 1];
    for (int i = 0; i <= CUBES; ++i) {
        bodies[i] = duet_default_body();
        bodies[i].restitution = 0.5f;
        const duet_pose cube = {{3.0f * (float)(i % 5), 3.0f * (float)(i / 5), (float)i},
                                {0.5f, 0.5f, 0.5f},
                                {0, 0, 0, 1}};
        if (i > 0)
            poses[i] = cube;
    }
    bodies[0].mass = 0;
    duet_error err = {0};
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&devices, &err);
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.gravity[2] = -10;
    def.hit_speed = 1; // calls for events
    duet_motion *motion = pair ? duet_motion_create(&def, poses, bodies, CUBES + 1, &err) : NULL;
    duet_motion_result result;
    int hits[CUBES + 1] = {0};
    duet_hit_event hardest = {0};
    bool ok = motion != NULL;
    for (int step = 0; ok && step < STEPS; ++step) {
        ok = duet_motion_advance(motion, &result, &err);
        for (uint64_t i = 0; ok && i < result.n_hits; ++i) {
            ++hits[result.hits[i].b];
            if (result.hits[i].speed > hardest.speed)
                hardest = result.hits[i];
        }
    }
    for (int i = 1; ok && i <= CUBES; ++i)
        printf("cube %d hit the floor %d times\n", i, hits[i]);
    if (ok)
        printf("the hardest was cube %u, at %.1f m/s\n", hardest.b, (double)hardest.speed);
    else
        fprintf(stderr, "%s\n", err.text);
    duet_motion_destroy(motion);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
