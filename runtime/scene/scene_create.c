// SPDX-License-Identifier: MIT
// Makes a scene of objects in memory.
#include "runtime/scene/scene.h"

#include "base/error.h"
#include "runtime/narrowphase/rounded.h"

#include <stdlib.h>
#include <string.h>

// The scene where it is whole, else NULL and the scene's memory is given back.
static duet_scene *keep_if(bool ok, duet_scene *scene)
{
    if (ok)
        return scene;
    duet_scene_destroy(scene);
    return NULL;
}

static duet_scene *start_copy(duet_shape shape, const void *objects, uint32_t n, uint32_t dims,
                              duet_error *err)
{
    if (n > 0 && !objects)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "%u objects, but no memory that holds them", n);
    if (dims != 2 && dims != 3)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT, "dims is %u; it must be 2 or 3", dims);
    duet_scene *scene = scene_new(err);
    if (!scene)
        return NULL;
    scene->info.dims = dims;
    scene->info.shape = shape;
    return keep_if(scene_set_name(scene, "objects", strlen("objects"), err) &&
                       scene_reserve(scene, n > 0 ? n : 1, err),
                   scene);
}

static void write_pose(const duet_pose *pose, uint32_t dims, double *row)
{
    const uint32_t first = dims == 2 ? 2 : 0; // part of the quaternion
    for (uint32_t k = 0; k < dims; ++k) {
        row[k] = pose->centre[k];
        row[dims + k] = pose->half_extents[k];
    }
    for (uint32_t k = first; k < 4; ++k)
        row[2 * dims + k - first] = pose->rotation[k];
}

static void write_bounds(const duet_bounds *bounds, uint32_t dims, double *row)
{
    for (uint32_t k = 0; k < dims; ++k) {
        row[k] = bounds->lower[k];
        row[dims + k] = bounds->upper[k];
    }
}

// Object i as a row of that layout; what has a radius has it last.
static void write_row(const scene_layout *l, duet_shape shape, const void *objects, uint32_t i,
                      double *row)
{
    duet_rounded_box box = {.radius = 0};
    if (shape == DUET_SHAPE_BOUNDS) {
        write_bounds((const duet_bounds *)objects + i, l->dims, row);
        return;
    }
    if (shape == DUET_SHAPE_POSES)
        box.pose = ((const duet_pose *)objects)[i];
    else
        box = shape == DUET_SHAPE_SPHERES ? rounded_of_sphere((const duet_sphere *)objects + i)
                                          : ((const duet_rounded_box *)objects)[i];
    write_pose(&box.pose, l->dims, row);
    if (scene_layout_has_radius(l))
        row[l->n - 1] = box.radius;
}

static duet_scene *create(duet_shape shape, const void *objects, uint32_t n, uint32_t dims,
                          duet_error *err)
{
    bool bounds = shape == DUET_SHAPE_BOUNDS, rounded = !bounds && shape != DUET_SHAPE_POSES;
    const scene_layout *l = bounds      ? scene_layout_find(2 * dims)
                            : rounded   ? scene_layout_rounded_box(dims)
                            : dims == 2 ? &scene_layout_pose_2d
                                        : scene_layout_find(10);
    duet_scene *scene =
        start_copy(bounds ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES, objects, n, dims, err);
    bool ok = scene && (!rounded || scene_begin_radii(scene, err));
    for (uint32_t i = 0; ok && i < n; ++i) {
        double row[SCENE_MAX_COLUMNS];
        write_row(l, shape, objects, i, row);
        ok = scene_add_object(scene, l, row, (scene_place){0}, err);
    }
    return keep_if(ok && (!rounded || scene_join_radii(scene, shape, err)), scene);
}

static duet_scene *create_placed(const duet_large_pose *placed, uint32_t n, uint32_t dims,
                                 float origin, duet_error *err)
{
    if (n > 0 && !error_given(placed, "duet_scene_create", "objects", err))
        return NULL;
    duet_pose *poses = calloc(n > 0 ? n : 1, sizeof *poses);
    if (!poses)
        return null_no_memory(err, "%u poses", n);
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = placed[i].pose;
    duet_scene *scene = create(DUET_SHAPE_POSES, placed ? poses : NULL, n, dims, err);
    free(poses);
    return keep_if(scene && scene_set_origin(scene, placed, origin, err), scene);
}

duet_scene *duet_scene_create(duet_object_kind kind, const void *objects, uint32_t n, uint32_t dims,
                              float origin_edge, duet_error *err)
{
    PUBLIC_CALL(err);
    if (origin_edge != 0.0f && kind != DUET_OBJECT_LARGE_POSES)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "origin_edge is %g; expected 0 for objects that are not large poses",
                          (double)origin_edge);
    switch (kind) {
    case DUET_OBJECT_POSES:
        return create(DUET_SHAPE_POSES, objects, n, dims, err);
    case DUET_OBJECT_BOUNDS:
        return create(DUET_SHAPE_BOUNDS, objects, n, dims, err);
    case DUET_OBJECT_LARGE_POSES:
        return create_placed(objects, n, dims, origin_edge, err);
    case DUET_OBJECT_ROUNDED_BOXES:
        return create(DUET_SHAPE_ROUNDED_BOXES, objects, n, dims, err);
    case DUET_OBJECT_SPHERES:
        return create(DUET_SHAPE_SPHERES, objects, n, dims, err);
    case DUET_OBJECT_TRANSFORMS:
    case DUET_OBJECT_SIZES:
    case DUET_OBJECT_COMPACT_TRANSFORMS:
        break;
    }
    return error_null(
        err, DUET_STATUS_BAD_ARGUMENT,
        "kind is %d; expected poses, bounds, large poses, rounded boxes or spheres for a "
        "scene",
        (int)kind);
}
