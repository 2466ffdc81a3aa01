// SPDX-License-Identifier: MIT
// Scenes whose boxes have a radius: poses and radii side by side while they are read, then
// objects of one shape.
#include "runtime/scene/scene.h"

#include "base/budget.h"
#include "base/error.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <stdlib.h>
#include <string.h>

bool scene_begin_radii(duet_scene *scene, duet_error *err)
{
    if (!scene->radii)
        scene->radii = calloc(scene->capacity, sizeof *scene->radii);
    return scene->radii || no_memory(err, "%llu radii", (unsigned long long)scene->capacity);
}

bool scene_reserve_radii(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (!scene->radii)
        return true;
    float *radii = realloc(scene->radii, n * sizeof *radii);
    if (!radii)
        return no_memory(err, "%llu radii", (unsigned long long)n);
    scene->radii = radii;
    return true;
}

static bool all_are_spheres(const duet_scene *scene)
{
    const duet_pose *poses = scene->objects;
    bool all = true;
    for (uint32_t i = 0; all && i < scene->info.n; ++i)
        for (uint32_t k = 0; k < scene->info.dims; ++k)
            all &= poses[i].half_extents[k] == 0;
    return all;
}

static void make_rounded(const duet_scene *scene, uint32_t i, void *objects)
{
    const duet_pose *pose = &((const duet_pose *)scene->objects)[i];
    if (scene->info.shape == DUET_SHAPE_SPHERES) {
        duet_sphere *s = &((duet_sphere *)objects)[i];
        memcpy(s->centre, pose->centre, sizeof s->centre);
        s->radius = scene->radii[i];
        return;
    }
    ((duet_rounded_box *)objects)[i] = (duet_rounded_box){*pose, scene->radii[i]};
}

bool scene_join_radii(duet_scene *scene, duet_shape shape, duet_error *err)
{
    uint32_t n = scene->info.n;
    scene->info.shape = shape;
    size_t each = origin_row_bytes(shape, scene->info.origin_edge);
    size_t bytes = (n > 0 ? n : 1) * each;
    void *objects = budget_space(bytes, err) ? malloc(bytes) : NULL;
    if (!objects)
        return no_memory(err, "%u objects of %zu bytes", n, each);
    for (uint32_t i = 0; i < n; ++i)
        make_rounded(scene, i, objects);
    if (shape == DUET_SHAPE_SPHERES)
        scene->info.rotated = false;
    free(scene->objects);
    free(scene->radii);
    scene->objects = objects;
    scene->radii = NULL;
    scene->capacity = n > 0 ? n : 1;
    return true;
}

bool scene_settle_radii(duet_scene *scene, duet_error *err)
{
    duet_shape shape =
        scene->radii && all_are_spheres(scene) ? DUET_SHAPE_SPHERES : DUET_SHAPE_ROUNDED_BOXES;
    return !scene->radii || scene_join_radii(scene, shape, err);
}

duet_rounded_box scene_rounded_box(const duet_scene *scene, uint32_t id)
{
    return scene->info.shape == DUET_SHAPE_SPHERES
               ? rounded_of_sphere(&((const duet_sphere *)scene->objects)[id])
               : ((const duet_rounded_box *)scene->objects)[id];
}
