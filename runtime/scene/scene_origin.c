// SPDX-License-Identifier: MIT
// Scenes whose poses are placed in origin cells.
#include "runtime/scene/scene.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <stdlib.h>

static bool check_edge(const duet_scene *scene, double edge, duet_error *err)
{
    if (!(edge > 0.0) || (double)(float)edge != edge || !origin_is_edge((float)edge))
        return bad_argument(
            err, "%s: the origin cells' edge is %g; it must be a power of two from 2^-100 to 2^100",
            scene->name, edge);
    if (scene->radii)
        return bad_input(err, "%s: origin cells are for boxes without a radius", scene->name);
    return scene->info.shape == DUET_SHAPE_POSES ||
           bad_input(err,
                     "%s: origin cells are for boxes by centre and half extents, not by corners",
                     scene->name);
}

static bool refuse_far(const duet_scene *scene, uint32_t id, double edge, duet_error *err)
{
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "%s: object %u is beyond 2^30 origin cells of edge %g from 0", scene->name, id,
                     edge);
}

bool scene_set_origin(duet_scene *scene, const duet_large_pose *given, double edge, duet_error *err)
{
    uint32_t n = scene->info.n;
    if (!check_edge(scene, edge, err))
        return false;
    duet_large_pose *placed = calloc(n > 0 ? n : 1, sizeof *placed);
    if (!placed)
        return no_memory(err, "%u placed poses", n);
    duet_pose *poses = scene->rounded = scene->objects;
    scene->objects = placed;
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        placed[i].pose = poses[i];
        for (uint32_t k = 0; given && k < scene->info.dims; ++k)
            placed[i].cell[k] = given[i].cell[k];
        ok = given ? origin_settle(&placed[i], (float)edge)
                   : origin_place(&placed[i], scene->centres[i], (float)edge);
        for (uint32_t k = 0; given && k < scene->info.dims; ++k)
            poses[i].centre[k] =
                (float)((double)placed[i].cell[k] * edge + (double)placed[i].pose.centre[k]);
        ok = ok || refuse_far(scene, i, edge, err);
    }
    scene->capacity = n > 0 ? n : 1;
    scene->info.origin_edge = (float)edge;
    return ok;
}

// Centres are of use only while a scene is made.
void scene_forget_centres(duet_scene *scene)
{
    free(scene->centres);
    scene->centres = NULL;
    scene->keep_centres = false;
}
