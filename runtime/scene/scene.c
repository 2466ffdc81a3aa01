// SPDX-License-Identifier: MIT
// The owner of objects and their world, and the makers that fill one.
#define _POSIX_C_SOURCE 200809L
#include "runtime/scene/scene.h"

#include "base/budget.h"
#include "base/error.h"
#include "base/text_file.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/scene/scene_row.h"
#include "runtime/scene/shipped.h"

#include <fcntl.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define STDIN_NAME "stdin"

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
        return error_set(err, DUET_STATUS_NO_MEMORY, "%llu centres in double: no memory",
                         (unsigned long long)n);
    scene->centres = centres;
    return true;
}

// The first object that has a radius: those before it have none.
static bool begin_radii(duet_scene *scene, duet_error *err)
{
    if (!scene->radii)
        scene->radii = calloc(scene->capacity, sizeof *scene->radii);
    return scene->radii || error_set(err, DUET_STATUS_NO_MEMORY, "%llu radii: no memory",
                                     (unsigned long long)scene->capacity);
}

static bool reserve_radii(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (!scene->radii)
        return true;
    float *radii = realloc(scene->radii, n * sizeof *radii);
    if (!radii)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%llu radii: no memory",
                         (unsigned long long)n);
    scene->radii = radii;
    return true;
}

bool scene_reserve(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (n <= scene->capacity)
        return true;
    if (n > SCENE_MAX_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu objects; a scene holds at most %u",
                         (unsigned long long)n, SCENE_MAX_OBJECTS);
    if (!budget_space(n * object_size(scene), err))
        return false;
    void *objects = realloc(scene->objects, n * object_size(scene));
    if (!objects)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%llu objects of %zu bytes: no memory",
                         (unsigned long long)n, object_size(scene));
    scene->objects = objects;
    if (!reserve_centres(scene, n, err) || !reserve_radii(scene, n, err))
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
    if (doubled > SCENE_MAX_OBJECTS)
        doubled = SCENE_MAX_OBJECTS;
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

static bool add(duet_scene *scene, const scene_layout *l, const double *row, scene_place place,
                duet_error *err)
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
    if (rounded && !begin_radii(scene, err))
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
        if (!add(scene, l, row + i * l->n, place, err))
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
        return error_set(err, DUET_STATUS_BAD_INPUT,
                         "%s%s %llu has %u numbers, where those before it have %u",
                         scene_place_name(place).chars, what, i, columns, scene->columns);
    if (!l)
        return error_set(err, DUET_STATUS_BAD_INPUT, "%s%s %llu has %u numbers; it must have %s",
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

// ------------------------------------------------------------------ radii

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

// Makes poses and their radii into objects of that shape.
static bool join_radii(duet_scene *scene, duet_shape shape, duet_error *err)
{
    uint32_t n = scene->info.n;
    scene->info.shape = shape;
    size_t bytes = (n > 0 ? n : 1) * object_size(scene);
    void *objects = budget_space(bytes, err) ? malloc(bytes) : NULL;
    if (!objects)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%u objects of %zu bytes: no memory", n,
                         object_size(scene));
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

// What is read from a source has the shape that costs least.
static bool settle_radii(duet_scene *scene, duet_error *err)
{
    duet_shape shape =
        scene->radii && all_are_spheres(scene) ? DUET_SHAPE_SPHERES : DUET_SHAPE_ROUNDED_BOXES;
    return !scene->radii || join_radii(scene, shape, err);
}

// ------------------------------------------------------------------ makers

// An empty scene, which is 3D poses until rows say otherwise.
static duet_scene *scene_new(duet_error *err)
{
    duet_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return error_null(err, DUET_STATUS_NO_MEMORY, "a scene: no memory");
    scene->info.dims = 3;
    scene->info.shape = DUET_SHAPE_POSES;
    scene->per_row = 1;
    scene->end = UINT64_MAX;
    scene->motion = duet_default_motion_def();
    scene->body = duet_default_body();
    return scene;
}

// The scene where it is whole, else NULL and the scene's memory is given back.
static duet_scene *keep_if(bool ok, duet_scene *scene)
{
    if (ok)
        return scene;
    duet_scene_destroy(scene);
    return NULL;
}

// "boxes" for "data/boxes.csv".
static bool name_after_file(duet_scene *scene, const char *path, duet_error *err)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    return scene_set_name(scene, name, dot && dot > name ? (size_t)(dot - name) : strlen(name),
                          err);
}

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path);
    size_t n = strlen(ending);
    return length >= n && strcmp(path + length - n, ending) == 0;
}

// What can be set of a file that is data alone: origin=cell, and the cells' edge.
static bool read_origin(const char *path, const duet_setting *settings, uint32_t n_settings,
                        double *edge, duet_error *err)
{
    bool wanted = false;
    double given = 1.0;
    for (uint32_t i = 0; i < n_settings; ++i) {
        const duet_setting *s = &settings[i];
        if (strcmp(s->name, "origin") == 0 && strcmp(s->value, "cell") == 0)
            wanted = true;
        else if (strcmp(s->name, "origin_edge") == 0)
            given = strtod(s->value, NULL);
        else
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: '%s' is set, but only a .lua scene has parameters; of data "
                             "origin=cell and origin_edge can be set",
                             path, s->name);
    }
    *edge = wanted ? given : 0.0;
    return true;
}

// ----------------------------------------------------------------- sources

typedef enum source_kind { SOURCE_LUA, SOURCE_NPY, SOURCE_TEXT } source_kind;

// A file says it by its ending, stdin by what it holds.
static source_kind kind_of(const scene_source *source)
{
    if (strcmp(source->name, STDIN_NAME) != 0)
        return has_ending(source->name, ".lua")   ? SOURCE_LUA
               : has_ending(source->name, ".npy") ? SOURCE_NPY
                                                  : SOURCE_TEXT;
    if (source->length > 0 && source->bytes[0] == '\x93')
        return SOURCE_NPY;
    return scene_is_text(source) ? SOURCE_TEXT : SOURCE_LUA;
}

static bool refuse_path(const char *path, const duet_error *why, duet_error *err)
{
    shipped_scene near;
    if (why->status != DUET_STATUS_NOT_FOUND || strpbrk(path, "/."))
        return error_copy(err, why);
    if (shipped_find_nearest(path, &near))
        return error_set(err, why->status, "%s: no such file or scene; did you mean '%s'?", path,
                         near.name);
    return error_set(err, why->status, "%s: no such file or scene; 'duet scenes' lists the scenes",
                     path);
}

// Of a .npy file only the rows that are kept are read, so it stays where it is.
static bool open_rows(const char *path, scene_source *source)
{
    struct stat info;
    int file = has_ending(path, ".npy") ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file >= 0 && fstat(file, &info) == 0 && S_ISREG(info.st_mode)) {
        *source = (scene_source){.name = path, .length = (size_t)info.st_size, .file = file};
        return true;
    }
    if (file >= 0)
        close(file);
    return false;
}

// What the path means: a scene that comes with Duet by its name, also by its path in the
// source tree where that is not; "-", which is stdin; or a file. The bytes of the last two
// are in *file.
static bool open_source(const char *path, scene_source *source, text *file, duet_error *err)
{
    shipped_scene shipped;
    const blob *carried = shipped_find(path, &shipped) ? shipped.file
                          : access(path, F_OK) != 0    ? blob_find(path)
                                                       : NULL;
    if (carried) {
        *source = (scene_source){carried->path, carried->bytes, carried->length, -1};
        return true;
    }
    if (open_rows(path, source))
        return true;
    duet_error why = {0};
    if (!text_read_lines(file, path, &why))
        return refuse_path(path, &why, err);
    *source = (scene_source){strcmp(path, "-") == 0 ? STDIN_NAME : path, text_chars(file),
                             file->length, -1};
    return true;
}

static bool read_objects(duet_scene *scene, const scene_source *source,
                         const duet_setting *settings, uint32_t n_settings, duet_error *err)
{
    switch (kind_of(source)) {
    case SOURCE_LUA:
        return scene_read_lua(scene, source, settings, n_settings, err);
    case SOURCE_NPY:
        return scene_read_npy(scene, source, err);
    case SOURCE_TEXT:
        return scene_read_text(scene, source, err);
    }
    return false;
}

// A script says only after its objects whether they are to be placed.
static bool read_source(duet_scene *scene, const scene_source *source, const duet_setting *settings,
                        uint32_t n_settings, duet_error *err)
{
    bool lua = kind_of(source) == SOURCE_LUA;
    double edge = 0.0;
    if (lua && scene->per_row == 2)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: pairs are read from .npy or text",
                         source->name);
    if (!lua && !read_origin(source->name, settings, n_settings, &edge, err))
        return false;
    scene->keep_centres = lua || edge != 0.0;
    bool ok = scene_reserve(scene, 1, err) &&
              read_objects(scene, source, settings, n_settings, err) &&
              (edge == 0.0 || scene_set_origin(scene, edge, err)) && settle_radii(scene, err);
    scene_forget_centres(scene);
    return ok;
}

static bool read_path(duet_scene *scene, const char *path, const duet_setting *settings,
                      uint32_t n_settings, duet_error *err)
{
    text file = {0};
    scene_source source = {.file = -1};
    bool ok = open_source(path, &source, &file, err) && name_after_file(scene, source.name, err) &&
              read_source(scene, &source, settings, n_settings, err);
    text_free(&file);
    if (source.file >= 0)
        close(source.file);
    return ok;
}

// Which objects of a source are kept, and how many it has.
typedef struct scene_range {
    uint64_t first, end;
    uint64_t n;
    bool defers;
    uint64_t n_deferred;
} scene_range;

static duet_scene *load(const char *path, uint32_t per_row, scene_range *range,
                        const duet_setting *settings, uint32_t n_settings, duet_error *err)
{
    // Numbers have a decimal point whatever the application's language.
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    duet_scene *scene = plain ? scene_new(err) : NULL;
    bool ok = scene;
    if (ok) {
        scene->per_row = per_row;
        scene->first = range->first;
        scene->end = range->end;
        scene->defers = range->defers;
        locale_t before = uselocale(plain);
        ok = read_path(scene, path, settings, n_settings, err);
        uselocale(before);
        range->n = scene->n_read;
        range->n_deferred = scene->n_deferred;
    }
    if (plain)
        freelocale(plain);
    else
        error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory", path);
    return keep_if(ok, scene);
}

duet_scene *scene_load_range(const char *path, const duet_setting *settings, uint32_t n_settings,
                             uint64_t first, uint64_t end, uint64_t *n, duet_error *err)
{
    scene_range range = {.first = first, .end = end};
    duet_scene *scene = load(path, 1, &range, settings, n_settings, err);
    *n = range.n;
    return scene;
}

static bool check_settings(const duet_setting *settings, uint32_t n, const char *call,
                           duet_error *err)
{
    bool ok = n == 0 || error_given(settings, call, "settings", err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = error_given(settings[i].name, call, "a setting's name", err) &&
             error_given(settings[i].value, call, "a setting's value", err);
    return ok;
}

duet_scene *scene_load_deferred(const char *path, const duet_setting *settings, uint32_t n_settings,
                                uint64_t *n, uint64_t *deferred, duet_error *err)
{
    scene_range range = {.end = UINT64_MAX, .defers = true};
    bool ok = check_settings(settings, n_settings, "duet_cluster_load_scene", err);
    duet_scene *scene = ok ? load(path, 1, &range, settings, n_settings, err) : NULL;
    *n = range.n;
    *deferred = range.n_deferred;
    return scene;
}

duet_scene *duet_scene_load(const char *path, const duet_setting *settings, uint32_t n_settings,
                            duet_error *err)
{
    scene_range all = {.end = UINT64_MAX};
    bool ok = error_given(path, __func__, "path", err) &&
              check_settings(settings, n_settings, __func__, err);
    return ok ? load(path, 1, &all, settings, n_settings, err) : NULL;
}

duet_scene *duet_scene_load_pairs(const char *path, duet_error *err)
{
    scene_range all = {.end = UINT64_MAX};
    return error_given(path, __func__, "path", err) ? load(path, 2, &all, NULL, 0, err) : NULL;
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
    const uint32_t first = dims == 2 ? 2 : 0; // of the quaternion
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

duet_scene *scene_from_objects(duet_shape shape, const void *objects, uint32_t n, uint32_t dims,
                               duet_error *err)
{
    bool bounds = shape == DUET_SHAPE_BOUNDS, rounded = !bounds && shape != DUET_SHAPE_POSES;
    const scene_layout *l = bounds      ? scene_layout_find(2 * dims)
                            : rounded   ? scene_layout_rounded_box(dims)
                            : dims == 2 ? &scene_layout_pose_2d
                                        : scene_layout_find(10);
    duet_scene *scene =
        start_copy(bounds ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES, objects, n, dims, err);
    bool ok = scene && (!rounded || begin_radii(scene, err));
    for (uint32_t i = 0; ok && i < n; ++i) {
        double row[SCENE_MAX_COLUMNS];
        write_row(l, shape, objects, i, row);
        ok = add(scene, l, row, (scene_place){0}, err);
    }
    return keep_if(ok && (!rounded || join_radii(scene, shape, err)), scene);
}

duet_scene *duet_scene_create(duet_object_kind kind, const void *objects, uint32_t n, uint32_t dims,
                              float origin_edge, duet_error *err)
{
    if (origin_edge != 0.0f && kind != DUET_OBJECT_LARGE_POSES)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "origin_edge is %g; expected 0 for objects that are not large poses",
                          (double)origin_edge);
    switch (kind) {
    case DUET_OBJECT_POSES:
        return scene_from_objects(DUET_SHAPE_POSES, objects, n, dims, err);
    case DUET_OBJECT_BOUNDS:
        return scene_from_objects(DUET_SHAPE_BOUNDS, objects, n, dims, err);
    case DUET_OBJECT_LARGE_POSES:
        return scene_from_large_poses(objects, n, dims, origin_edge, err);
    case DUET_OBJECT_ROUNDED_BOXES:
        return scene_from_objects(DUET_SHAPE_ROUNDED_BOXES, objects, n, dims, err);
    case DUET_OBJECT_SPHERES:
        return scene_from_objects(DUET_SHAPE_SPHERES, objects, n, dims, err);
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

static bool reorder(void *rows, size_t bytes, uint32_t n, const uint32_t *order, duet_error *err)
{
    if (!rows || n == 0)
        return true;
    char *old = malloc(n * bytes);
    if (!old)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory to reorder %u objects", n);
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
    free(scene);
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

duet_rounded_box scene_rounded_box(const duet_scene *scene, uint32_t id)
{
    return scene->info.shape == DUET_SHAPE_SPHERES
               ? rounded_of_sphere(&((const duet_sphere *)scene->objects)[id])
               : ((const duet_rounded_box *)scene->objects)[id];
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
