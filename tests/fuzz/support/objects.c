// SPDX-License-Identifier: MIT
#include "support/objects.h"

#include "support/fuzz.h"

#include <math.h>
#include <string.h>

static void require_pose(const duet_pose *p, uint32_t dims)
{
    double norm = 0;
    for (uint32_t k = 0; k < dims; ++k)
        fuzz_require(isfinite(p->centre[k]) && isfinite(p->half_extents[k]) &&
                     p->half_extents[k] >= 0);
    for (uint32_t k = 0; k < 4; ++k)
        norm += (double)p->rotation[k] * (double)p->rotation[k];
    fuzz_require(norm > 0 && isfinite(norm));
}

static void require_bounds(const duet_bounds *b, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        fuzz_require(isfinite(b->lower[k]) && isfinite(b->upper[k]) && b->lower[k] <= b->upper[k]);
}

static void require_placed(const duet_large_pose *p, uint32_t dims, float edge)
{
    require_pose(&p->pose, dims);
    for (uint32_t k = 0; k < dims; ++k)
        fuzz_require(p->pose.centre[k] >= 0 && p->pose.centre[k] < edge);
}

static void require_radius(float radius)
{
    fuzz_require(isfinite(radius) && radius >= 0);
}

static void require_sphere(const duet_sphere *s, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        fuzz_require(isfinite(s->centre[k]));
    require_radius(s->radius);
}

void fuzz_require_objects(const duet_scene *scene)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    const duet_bounds *bounds = duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS);
    const duet_large_pose *placed = duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES);
    const duet_rounded_box *rounded = duet_scene_get_objects(scene, DUET_OBJECT_ROUNDED_BOXES);
    const duet_sphere *spheres = duet_scene_get_objects(scene, DUET_OBJECT_SPHERES);
    fuzz_require(info->n == 0 || poses || bounds || placed || rounded || spheres);
    for (uint32_t i = 0; i < info->n; ++i) {
        if (placed)
            require_placed(&placed[i], info->dims, info->origin_edge);
        else if (poses)
            require_pose(&poses[i], info->dims);
        else if (rounded)
            require_pose(&rounded[i].pose, info->dims);
        else if (spheres)
            require_sphere(&spheres[i], info->dims);
        else
            require_bounds(&bounds[i], info->dims);
        if (rounded)
            require_radius(rounded[i].radius);
    }
}

void fuzz_require_same(const duet_scene *a, const duet_scene *b)
{
    const duet_scene_info *x = duet_scene_get_info(a);
    const duet_scene_info *y = duet_scene_get_info(b);
    fuzz_require(x->n == y->n && x->dims == y->dims && x->shape == y->shape);
    fuzz_require(strcmp(x->name, y->name) == 0);
    static const struct {
        duet_object_kind kind;
        size_t bytes;
    } kinds[] = {{DUET_OBJECT_POSES, sizeof(duet_pose)},
                 {DUET_OBJECT_BOUNDS, sizeof(duet_bounds)},
                 {DUET_OBJECT_LARGE_POSES, sizeof(duet_large_pose)},
                 {DUET_OBJECT_ROUNDED_BOXES, sizeof(duet_rounded_box)},
                 {DUET_OBJECT_SPHERES, sizeof(duet_sphere)}};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        const void *of_a = duet_scene_get_objects(a, kinds[k].kind);
        const void *of_b = duet_scene_get_objects(b, kinds[k].kind);
        fuzz_require(!of_a == !of_b);
        fuzz_require(!of_a || memcmp(of_a, of_b, x->n * kinds[k].bytes) == 0);
    }
}

static bool load(const char *path, const duet_setting *settings, uint32_t n_settings)
{
    duet_error err = {0};
    duet_scene *scene = duet_scene_load(path, settings, n_settings, &err);
    fuzz_require_answer(scene != NULL, &err);
    if (scene)
        fuzz_require_objects(scene);
    duet_scene_destroy(scene);
    return scene != NULL;
}

void fuzz_read_objects(const char *name, const uint8_t *data, size_t n)
{
    static const duet_setting cells[] = {{"origin", "cell"}, {"origin_edge", "4"}};
    fuzz_path path = fuzz_file(name, data, n);
    if (load(path.chars, NULL, 0))
        load(path.chars, cells, 2);
}
