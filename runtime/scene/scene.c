// SPDX-License-Identifier: MIT
// The owner of objects and their world, and how they come in.
#include "runtime/scene/scene.h"

#include "base/budget.h"
#include "base/error.h"
#include "base/text.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/scene/mesh_file.h"

#include <stdlib.h>
#include <string.h>

duet_scene *scene_new(duet_error *err)
{
    duet_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return null_no_memory(err, "a scene");
    scene->info.dims = 3;
    scene->info.shape = DUET_SHAPE_POSES;
    scene->per_row = 1;
    scene->end = UINT64_MAX;
    scene->motion = duet_default_motion_def();
    scene->body = duet_default_body();
    return scene;
}

void duet_scene_destroy(duet_scene *scene)
{
    if (!scene)
        return;
    free(scene->objects);
    free(scene->centres);
    free(scene->radii);
    free(scene->rounded);
    free(scene->name);
    free(scene->given);
    free(scene->bodies);
    free(scene->height_values);
    mesh_file_free(&scene->mesh);
    free(scene);
}

// ----------------------------------------------------------------- filling

static size_t object_size(const duet_scene *scene)
{
    return origin_row_bytes(scene->info.shape, scene->info.origin_edge);
}

static bool reserve_centres(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (!scene->keep_centres)
        return true;
    void *centres = realloc(scene->centres, n * sizeof *scene->centres);
    if (!centres)
        return no_memory(err, "%llu centres in double", (unsigned long long)n);
    scene->centres = centres;
    return true;
}

bool scene_reserve(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (n <= scene->capacity)
        return true;
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu objects; a scene holds at most %u",
                         (unsigned long long)n, DUET_MOST_OBJECTS);
    if (!budget_space(n * object_size(scene), err))
        return false;
    void *objects = realloc(scene->objects, n * object_size(scene));
    if (!objects)
        return no_memory(err, "%llu objects of %zu bytes", (unsigned long long)n,
                         object_size(scene));
    scene->objects = objects;
    if (!reserve_centres(scene, n, err) || !scene_reserve_radii(scene, n, err))
        return false;
    scene->capacity = n;
    return true;
}

static bool reserve_one_more(duet_scene *scene, duet_error *err)
{
    uint64_t n = (uint64_t)scene->info.n + 1;
    if (n <= scene->capacity)
        return true;
    uint64_t doubled = 2 * scene->capacity;
    if (doubled > DUET_MOST_OBJECTS)
        doubled = DUET_MOST_OBJECTS;
    return scene_reserve(scene, n > doubled ? n : doubled, err);
}

uint64_t scene_pass_over(duet_scene *scene, uint64_t n)
{
    uint64_t next = scene->n_read >= scene->end    ? UINT64_MAX
                    : scene->n_read < scene->first ? scene->first
                                                   : scene->n_read;
    uint64_t passed = next - scene->n_read < n ? next - scene->n_read : n;
    scene->n_read += passed;
    return passed;
}

bool scene_add_object(duet_scene *scene, const scene_layout *l, const double *row,
                      scene_place place, duet_error *err)
{
    if (scene_pass_over(scene, 1) > 0)
        return true;
    if (!scene_row_check(l, row, scene->n_read, place, err) || !reserve_one_more(scene, err))
        return false;
    void *object = (char *)scene->objects + scene->info.n * object_size(scene);
    l->store(row, object);
    if (l->shape == DUET_SHAPE_POSES) {
        const float *q = ((const duet_pose *)object)->rotation;
        scene->info.rotated |= q[0] != 0 || q[1] != 0 || q[2] != 0;
    }
    bool rounded = scene_layout_has_radius(l);
    if (rounded && !scene_begin_radii(scene, err))
        return false;
    if (scene->radii)
        scene->radii[scene->info.n] = rounded ? (float)row[l->n - 1] : 0.0f;
    if (scene->keep_centres)
        for (uint32_t k = 0; k < 3; ++k)
            scene->centres[scene->info.n][k] = k < l->dims ? row[k] : 0.0;
    ++scene->info.n;
    ++scene->n_read;
    return true;
}

static const scene_layout *layout_of(const duet_scene *scene, uint32_t columns)
{
    const scene_layout *l = scene_layout_find(columns / scene->per_row);
    bool whole = columns % scene->per_row == 0;
    bool poses = l && l->shape == DUET_SHAPE_POSES && !scene_layout_has_radius(l);
    return whole && (scene->per_row == 1 || poses) ? l : NULL;
}

bool scene_columns_fit(const duet_scene *scene, uint64_t columns)
{
    return columns <= SCENE_MAX_NUMBERS && layout_of(scene, (uint32_t)columns);
}

const char *scene_columns_right(const duet_scene *scene)
{
    return scene->per_row == 1 ? "4, 5, 6, 7, 10 or 11" : "20, or 10 in 2D";
}

bool scene_add_row(duet_scene *scene, const double *row, scene_place place, duet_error *err)
{
    const scene_layout *l = layout_of(scene, scene->columns);
    place.in_pairs = scene->per_row == 2;
    for (uint32_t i = 0; i < scene->per_row; ++i)
        if (!scene_add_object(scene, l, row + i * l->n, place, err))
            return false;
    return true;
}

// Whether such rows are boxes as those before them, but for the radius.
static bool may_mix(const duet_scene *scene, const scene_layout *l)
{
    return scene->mixes && l && l->shape == DUET_SHAPE_POSES && l->dims == scene->info.dims &&
           scene->info.shape == DUET_SHAPE_POSES;
}

bool scene_set_columns(duet_scene *scene, uint32_t columns, scene_place place, duet_error *err)
{
    const scene_layout *l = layout_of(scene, columns);
    const char *what = scene->per_row == 1 ? "object" : "pair";
    unsigned long long i = scene->n_read / scene->per_row;
    if (scene->columns != 0 && columns != scene->columns && !may_mix(scene, l))
        return bad_input(err, "%s%s %llu has %u numbers, where those before it have %u",
                         scene_place_name(place).chars, what, i, columns, scene->columns);
    if (!l)
        return bad_input(err, "%s%s %llu has %u numbers; it must have %s",
                         scene_place_name(place).chars, what, i, columns,
                         scene_columns_right(scene));
    scene->columns = columns;
    scene->info.dims = l->dims;
    scene->info.shape = l->shape;
    return true;
}

bool scene_set_name(duet_scene *scene, const char *name, size_t length, duet_error *err)
{
    text shown = {0};
    text_add_visible(&shown, name, length, "");
    text_add(&shown, "%s", ""); // a name of no characters has a place too
    if (!text_ok(&shown, err)) {
        text_free(&shown);
        return false;
    }
    free(scene->name);
    scene->name = shown.chars;
    scene->info.name = shown.chars;
    return true;
}

static bool reorder(void *rows, size_t bytes, uint32_t n, const uint32_t *order, duet_error *err)
{
    if (!rows || n == 0)
        return true;
    char *old = malloc(n * bytes);
    if (!old)
        return no_memory(err, "%u objects in order", n);
    memcpy(old, rows, n * bytes);
    for (uint32_t i = 0; i < n; ++i)
        memcpy((char *)rows + i * bytes, old + order[i] * bytes, bytes);
    free(old);
    return true;
}

bool scene_reorder(duet_scene *scene, const uint32_t *order, duet_error *err)
{
    const duet_scene_info *info = &scene->info;
    return reorder(scene->objects, origin_row_bytes(info->shape, info->origin_edge), info->n, order,
                   err) &&
           reorder(scene->rounded, sizeof *scene->rounded, info->n, order, err) &&
           reorder(scene->bodies, sizeof *scene->bodies, info->n, order, err);
}

// ----------------------------------------------------------------- reading

const duet_scene_info *duet_scene_get_info(const duet_scene *scene)
{
    return scene ? &scene->info : NULL;
}

const void *duet_scene_get_objects(const duet_scene *scene, duet_object_kind kind)
{
    if (!scene)
        return NULL;
    duet_shape shape = scene->info.shape;
    bool large = scene->info.origin_edge > 0.0f;
    switch (kind) {
    case DUET_OBJECT_POSES:
        return large ? scene->rounded : shape == DUET_SHAPE_POSES ? scene->objects : NULL;
    case DUET_OBJECT_BOUNDS:
        return shape == DUET_SHAPE_BOUNDS ? scene->objects : NULL;
    case DUET_OBJECT_LARGE_POSES:
        return large ? scene->objects : NULL;
    case DUET_OBJECT_ROUNDED_BOXES:
        return shape == DUET_SHAPE_ROUNDED_BOXES ? scene->objects : NULL;
    case DUET_OBJECT_SPHERES:
        return shape == DUET_SHAPE_SPHERES ? scene->objects : NULL;
    case DUET_OBJECT_TRANSFORMS:
    case DUET_OBJECT_SIZES:
    case DUET_OBJECT_COMPACT_TRANSFORMS:
        break;
    }
    return NULL;
}

duet_world_def duet_scene_world_def(const duet_scene *scene, duet_device_pair *pair)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    if (!scene)
        return def;
    const duet_scene_info *info = &scene->info;
    def.dims = info->dims;
    def.shape = info->shape;
    def.origin_edge = info->origin_edge;
    def.rotated = info->rotated;
    def.level = info->level;
    def.has_accuracy = info->has_accuracy;
    def.accuracy = info->accuracy;
    def.cell = info->cell;
    def.cell_fixed = info->cell_fixed;
    def.has_world = info->has_world;
    memcpy(def.lower, info->lower, sizeof def.lower);
    memcpy(def.upper, info->upper, sizeof def.upper);
    return def;
}
