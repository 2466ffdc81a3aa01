// SPDX-License-Identifier: MIT
// A world's objects, and a motion's, from a scene.
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"

bool duet_world_set_scene(duet_world *world, const duet_scene *scene, duet_error *err)
{
    if (!error_given(world, __func__, "world", err) || !error_given(scene, __func__, "scene", err))
        return false;
    const duet_scene_info *info = duet_scene_get_info(scene);
    if (info->dims != world->def.dims)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the scene %s has %u dimensions, the world %u", info->name, info->dims,
                         world->def.dims);
    if (info->origin_edge != world->def.origin_edge)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the scene %s has the origin %g, the world %g", info->name,
                         (double)info->origin_edge, (double)world->def.origin_edge);
    world_forget_grid(world);
    duet_object_kind kind = info->origin_edge > 0.0f          ? DUET_OBJECT_LARGE_POSES
                            : info->shape == DUET_SHAPE_POSES ? DUET_OBJECT_POSES
                                                              : DUET_OBJECT_BOUNDS;
    return duet_world_set_objects(world, kind, duet_scene_get_objects(scene, kind), info->n, err);
}

duet_motion *duet_motion_create_from_scene(const duet_motion_def *def, const duet_scene *scene,
                                           const duet_body *bodies, duet_error *err)
{
    if (!error_given(scene, __func__, "scene", err))
        return NULL;
    const duet_scene_info *info = duet_scene_get_info(scene);
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    const duet_body *own = bodies ? bodies : duet_scene_get_bodies(scene);
    if (!poses) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "%s: its objects are corners, which do not move; expected centres and half "
                  "extents",
                  info->name);
        return NULL;
    }
    if (def && def->origin_edge != info->origin_edge) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "the scene %s has origin cells of edge %g, the motion's def of %g", info->name,
                  (double)info->origin_edge, (double)def->origin_edge);
        return NULL;
    }
    return motion_create(def, poses, duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES), own,
                         info->n, err);
}
