// SPDX-License-Identifier: MIT
// A motion of a scene's objects.
#include "base/error.h"
#include "runtime/dynamics/motion.h"
#include "runtime/scene/scene.h"

#include <stdlib.h>

// A motion has cores as poses, and radii in its bodies.
static duet_motion *create_rounded(const duet_motion_def *def, const duet_scene *scene,
                                   const duet_body *own, duet_error *err)
{
    uint32_t n = duet_scene_get_info(scene)->n;
    duet_pose *poses = malloc(((size_t)n + 1) * sizeof *poses);
    duet_body *bodies = malloc(((size_t)n + 1) * sizeof *bodies);
    duet_motion *m = NULL;
    if (!poses || !bodies) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u objects that move", n);
        goto done;
    }
    for (uint32_t i = 0; i < n; ++i) {
        duet_rounded_box box = scene_rounded_box(scene, i);
        poses[i] = box.pose;
        bodies[i] = own ? own[i] : duet_default_body();
        bodies[i].radius = box.radius;
    }
    m = motion_create(def, poses, NULL, bodies, n, err);
done:
    free(poses);
    free(bodies);
    return m;
}

duet_motion *duet_motion_create_from_scene(const duet_motion_def *def, const duet_scene *scene,
                                           const duet_body *bodies, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(scene, __func__, "scene", err))
        return NULL;
    const duet_scene_info *info = duet_scene_get_info(scene);
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    const duet_body *own = bodies ? bodies : duet_scene_get_bodies(scene);
    if (info->shape == DUET_SHAPE_ROUNDED_BOXES || info->shape == DUET_SHAPE_SPHERES)
        return create_rounded(def, scene, own, err);
    if (!poses)
        return error_null(
            err, DUET_STATUS_BAD_ARGUMENT,
            "%s: its objects are corners, which do not move; expected centres and half "
            "extents",
            info->name);
    if (def && def->origin_edge != info->origin_edge)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "the scene %s has origin cells of edge %g, the motion's def of %g",
                          info->name, (double)info->origin_edge, (double)def->origin_edge);
    return motion_create(def, poses, duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES), own,
                         info->n, err);
}
