// SPDX-License-Identifier: MIT
#include "runtime/scene/scene_bodies.h"

#include "base/error.h"
#include "runtime/scene/scene.h"

#include <stdlib.h>

static bool make_rounded(scene_bodies *b, const duet_scene *scene, duet_error *err)
{
    b->made_poses = malloc(((size_t)b->n + 1) * sizeof *b->made_poses);
    b->made_bodies = malloc(((size_t)b->n + 1) * sizeof *b->made_bodies);
    if (!b->made_poses || !b->made_bodies)
        return no_memory(err, "%u objects that move", b->n);
    for (uint32_t i = 0; i < b->n; ++i) {
        duet_rounded_box box = scene_rounded_box(scene, i);
        b->made_poses[i] = box.pose;
        b->made_bodies[i] = b->bodies ? b->bodies[i] : duet_default_body();
        b->made_bodies[i].radius = box.radius;
    }
    b->poses = b->made_poses;
    b->bodies = b->made_bodies;
    return true;
}

bool scene_bodies_take(scene_bodies *b, const duet_scene *scene, const duet_body *bodies,
                       duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    *b = (scene_bodies){.n = info->n,
                        .poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES),
                        .bodies = bodies ? bodies : duet_scene_get_bodies(scene)};
    if (info->shape == DUET_SHAPE_ROUNDED_BOXES || info->shape == DUET_SHAPE_SPHERES)
        return make_rounded(b, scene, err);
    b->large_poses = duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES);
    return b->poses ||
           bad_argument(
               err,
               "%s: its objects are corners, which do not move; expected centres and half extents",
               info->name);
}

void scene_bodies_free(scene_bodies *b)
{
    free(b->made_poses);
    free(b->made_bodies);
    *b = (scene_bodies){0};
}
