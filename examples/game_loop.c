// SPDX-License-Identifier: MIT
// An application's start and its frames: what was tuned for such a world on
// such devices is loaded once, then every frame hands over poses and gets the
// colliding pairs.
#include <duet/duet.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

enum { BOXES = 5000, FRAMES = 300, ACROSS = 17 };

// Boxes on a lattice that sway, each by its own beat.
static void move_boxes(duet_pose *poses, int frame)
{
    for (int i = 0; i < BOXES; ++i) {
        float phase = 0.1f * (float)frame + (float)(i % 97);
        const duet_pose pose = {
            // centre
            {1.2f * (float)(i % ACROSS) + 0.2f * sinf(phase),
             1.2f * (float)(i / ACROSS % ACROSS) + 0.2f * cosf(phase),
             1.2f * (float)(i / ACROSS / ACROSS)},
            // half extents, rotation
            {0.5f, 0.5f, 0.5f},
            {0, 0, sinf(0.5f * phase), cosf(0.5f * phase)},
        };
        poses[i] = pose;
    }
}

static bool do_frame(duet_world *world, int frame, duet_result *result, duet_error *err)
{
    duet_pose *poses = (duet_pose *)duet_world_map_objects(world, DUET_OBJECT_POSES, BOXES, err);
    if (!poses)
        return false;
    move_boxes(poses, frame);
    return duet_world_step(world, result, err);
}

// The plan needs to know the objects, so the first frame's are there before.
static bool start(duet_world *world, duet_error *err)
{
    duet_pose *poses = (duet_pose *)duet_world_map_objects(world, DUET_OBJECT_POSES, BOXES, err);
    if (!poses)
        return false;
    move_boxes(poses, 0);
    duet_profile profile;
    duet_error why = {0};
    if (!duet_world_load_profile(world, NULL, &profile, &why))
        fprintf(stderr, "%s\n", why.text); // and the default plan does
    printf("plan: %s, share %.3f\n", duet_grade_name(profile.grade),
           (double)profile.plan.share / DUET_SHARE_ONE);
    return true;
}

int main(void)
{
    duet_error err = {0};
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&devices, &err);
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    if (pair)
        def.plan = duet_default_plan(pair);
    duet_world *world = pair ? duet_world_create(&def, &err) : NULL;
    bool ok = world && start(world, &err);
    double total_ms = 0;
    uint64_t collisions = 0;
    for (int frame = 0; ok && frame < FRAMES; ++frame) {
        duet_result result;
        ok = do_frame(world, frame, &result, &err);
        if (ok) {
            total_ms += result.total_ms;
            collisions += result.pairs;
        }
    }
    if (ok)
        printf("%d frames, %.3f ms each, %" PRIu64 " collisions\n", FRAMES, total_ms / FRAMES,
               collisions);
    else
        fprintf(stderr, "%s\n", err.text);
    duet_world_destroy(world);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
