// SPDX-License-Identifier: MIT
// A motion of a scene's objects.
#include "base/error.h"
#include "runtime/dynamics/motion_create.h"
#include "runtime/scene/scene_bodies.h"

static bool check_origin(const duet_motion_def *def, const duet_scene_info *info,
                         const scene_bodies *b, duet_error *err)
{
    if (!def || b->made_poses || def->origin_edge == info->origin_edge)
        return true;
    return bad_argument(err, "the scene %s has origin cells of edge %g, the motion's def of %g",
                        info->name, (double)info->origin_edge, (double)def->origin_edge);
}

duet_motion *duet_motion_create_from_scene(const duet_motion_def *def, const duet_scene *scene,
                                           const duet_body *bodies, duet_error *err)
{
    PUBLIC_CALL(err);
    scene_bodies b;
    duet_motion *m = NULL;
    if (!error_given(scene, __func__, "scene", err))
        return NULL;
    if (scene_bodies_take(&b, scene, bodies, err) &&
        check_origin(def, duet_scene_get_info(scene), &b, err))
        m = motion_create(def, b.poses, b.large_poses, b.bodies, b.n, err);
    scene_bodies_free(&b);
    return m;
}
