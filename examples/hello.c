// SPDX-License-Identifier: MIT
// Three boxes on two OpenCL devices: which of them collide?
#include <duet/duet.h>

#include <stdio.h>

int main(void)
{
    const duet_pose boxes[] = {
        {{0, 0, 0}, {1, 1, 1}, {0, 0, 0, 1}},          // centre, half extents, quaternion
        {{2.3f, 0, 0}, {1, 1, 1}, {0, 0, 0.3827f, 1}}, // turned, so that an edge reaches the first
        {{9, 0, 0}, {1, 1, 1}, {0, 0, 0, 1}},
    };
    duet_error err = {0};
    duet_result result = {0};
    duet_world_def def = duet_default_world_def();
    duet_device_pair *pair = duet_device_pair_open(NULL, &err);
    def.pair = pair;
    duet_world *world = pair ? duet_world_create(&def, &err) : NULL;
    bool ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, boxes, 3, &err);
    ok = ok && duet_world_step(world, &result, &err);
    for (uint64_t i = 0; ok && i < result.pairs; ++i)
        printf("%u and %u collide\n", duet_result_get_pair(&result, i).a,
               duet_result_get_pair(&result, i).b);
    if (!ok)
        fprintf(stderr, "%s\n", err.text);
    duet_world_destroy(world);
    duet_device_pair_destroy(pair);
    return ok ? 0 : 1;
}
