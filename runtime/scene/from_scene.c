// SPDX-License-Identifier: MIT
// A world's objects from a scene.
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/scene/scene.h"

duet_object_kind scene_kind(const duet_scene_info *info)
{
    return origin_row_kind(info->shape, info->origin_edge);
}

bool duet_world_set_scene(duet_world *world, const duet_scene *scene, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(world, __func__, "world", err) || !error_given(scene, __func__, "scene", err))
        return false;
    const duet_scene_info *info = duet_scene_get_info(scene);
    if (info->dims != world->def.dims)
        return bad_argument(err, "the scene %s has %u dimensions, the world %u", info->name,
                            info->dims, world->def.dims);
    if (info->origin_edge != world->def.origin_edge)
        return bad_argument(err, "the scene %s has the origin %g, the world %g", info->name,
                            (double)info->origin_edge, (double)world->def.origin_edge);
    world_forget_grid(world);
    duet_object_kind kind = scene_kind(info);
    return duet_world_set_objects(world, kind, duet_scene_get_objects(scene, kind), info->n, err);
}
