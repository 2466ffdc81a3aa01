// SPDX-License-Identifier: MIT
// A sensor that looks around on the ground while boxes fall: how far away is what it sees?
//
// cc range_sensor.c $(pkg-config --cflags --libs duet) && ./a.out
#include <duet/duet.h>

#include <stdio.h>

enum { BOXES = 4, RAYS = 4, STEPS = 120 };

// Floor and three boxes above it, 3, 5 and 7 to the right of the sensor.
static duet_motion *drop(duet_device_pair *pair, duet_error *err)
{
    duet_motion_def def = duet_default_motion_def();
    duet_pose poses[BOXES] = {{{0, 0, -1}, {20, 20, 1}, {0, 0, 0, 1}}};
    duet_body bodies[BOXES] = {duet_default_body()};
    bodies[0].mass = 0;
    for (int i = 1; i < BOXES; ++i) {
        const duet_pose box = {
            {1 + 2.0f * (float)i, 0, 4 - (float)i}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
        poses[i] = box;
        bodies[i] = duet_default_body();
    }
    def.pair = pair;
    def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    def.gravity[2] = -9.81;
    return duet_motion_create(&def, poses, bodies, BOXES, err);
}

// From half a unit above the ground: to the right, ahead, to the left and down.
static bool look(duet_motion *motion, duet_tree *tree, duet_ray_query *query, duet_error *err)
{
    static const duet_ray rays[RAYS] = {{{0, 0, 0.5f}, {1, 0, 0}, 50},
                                        {{0, 0, 0.5f}, {0, 1, 0}, 50},
                                        {{0, 0, 0.5f}, {-1, 0, 0}, 50},
                                        {{0, 0, 0.5f}, {0, 0, -1}, 50}};
    duet_ray_query_result seen;
    bool ok = duet_tree_set_motion(tree, motion, err) &&
              duet_ray_query_run(query, rays, RAYS, &seen, err);
    for (uint64_t i = 0; ok && i < seen.n_hits; ++i)
        if (seen.hits[i].id != DUET_NO_OBJECT)
            printf("  ray %u sees box %u at %.1f\n", seen.hits[i].ray, seen.hits[i].id,
                   (double)seen.hits[i].t);
    return ok;
}

static bool run(duet_device_pair *pair, duet_error *err)
{
    duet_ray_query_def query_def = duet_default_ray_query_def();
    duet_motion_result result = {0};
    duet_motion *motion = drop(pair, err);
    duet_tree_def def = duet_motion_tree_def(motion);
    duet_tree *tree = query_def.tree = motion ? duet_tree_create(&def, err) : NULL;
    duet_ray_query *query = tree ? duet_ray_query_create(&query_def, err) : NULL;
    bool ok = query;
    for (int step = 0; ok && step <= STEPS; ++step) {
        if (step % 40 == 0) {
            printf("after %.2f s\n", result.time);
            ok = look(motion, tree, query, err);
        }
        ok = ok && duet_motion_advance(motion, &result, err);
    }
    duet_ray_query_destroy(query);
    duet_tree_destroy(tree);
    duet_motion_destroy(motion);
    return ok;
}

int main(void)
{
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&def, &err);
    bool ok = pair && run(pair, &err);
    if (!ok)
        fprintf(stderr, "%s\n", err.text);
    duet_device_pair_destroy(pair);
    return !ok;
}
