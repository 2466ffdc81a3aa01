// SPDX-License-Identifier: MIT
// What an object may be, whoever brings it.
//
// Numbers arrive in double and are rounded to the nearest float once, after
// the checks, so that a negative extent too small for float is still refused.
#define _POSIX_C_SOURCE 200809L
#include "runtime/scene.h"

#include "runtime/base/error.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum column_kind {
    COORDINATE,
    HALF,    // >= 0
    ANGLE,   // radians; not stored, so it may be any finite double
    ROTATION // part of a quaternion; scaled before it is stored
} column_kind;

typedef struct column {
    const char *name;
    column_kind kind;
} column;

// A kind of row, and how one becomes an object.
typedef struct layout {
    uint32_t n;
    uint32_t dims;
    duet_shape shape;
    column columns[SCENE_MAX_COLUMNS];
    void (*store)(const double *row, void *object);
} layout;

static void store_bounds_2d(const double *row, void *object)
{
    *(duet_bounds *)object = (duet_bounds){
        .lower = {(float)row[0], (float)row[1]},
        .upper = {(float)row[2], (float)row[3]},
    };
}

static void store_bounds_3d(const double *row, void *object)
{
    *(duet_bounds *)object = (duet_bounds){
        .lower = {(float)row[0], (float)row[1], (float)row[2]},
        .upper = {(float)row[3], (float)row[4], (float)row[5]},
    };
}

// A quaternion's length does not count, but kernels square it in float. One
// that is very short or long is brought to a length near 1 by a power of two,
// which leaves its rotation exactly as it is.
static void store_rotation(double x, double y, double z, double w, duet_pose *pose)
{
    double greatest = fmax(fmax(fabs(x), fabs(y)), fmax(fabs(z), fabs(w)));
    int exponent = 0;
    frexp(greatest, &exponent);
    int shift = exponent < -32 || exponent > 32 ? -exponent : 0;
    const double q[4] = {x, y, z, w};
    for (int i = 0; i < 4; ++i)
        pose->rotation[i] = (float)ldexp(q[i], shift);
}

static void store_pose_2d(const double *row, void *object)
{
    duet_pose *pose = object;
    *pose = (duet_pose){
        .centre = {(float)row[0], (float)row[1]},
        .half = {(float)row[2], (float)row[3]},
    };
    store_rotation(0, 0, row[4], row[5], pose);
}

static void store_box_2d(const double *row, void *object)
{
    const double turn = row[4] / 2;
    store_pose_2d((const double[6]){row[0], row[1], row[2], row[3], sin(turn), cos(turn)}, object);
}

static void store_pose_3d(const double *row, void *object)
{
    duet_pose *pose = object;
    *pose = (duet_pose){
        .centre = {(float)row[0], (float)row[1], (float)row[2]},
        .half = {(float)row[3], (float)row[4], (float)row[5]},
    };
    store_rotation(row[6], row[7], row[8], row[9], pose);
}

// The rows that files have. No two have the same number of columns.
static const layout layouts[] = {
    {4,
     2,
     DUET_SHAPE_BOUNDS,
     {{"min x", COORDINATE}, {"min y", COORDINATE}, {"max x", COORDINATE}, {"max y", COORDINATE}},
     store_bounds_2d},
    {5,
     2,
     DUET_SHAPE_POSES,
     {{"cx", COORDINATE}, {"cy", COORDINATE}, {"hx", HALF}, {"hy", HALF}, {"angle", ANGLE}},
     store_box_2d},
    {6,
     3,
     DUET_SHAPE_BOUNDS,
     {{"min x", COORDINATE},
      {"min y", COORDINATE},
      {"min z", COORDINATE},
      {"max x", COORDINATE},
      {"max y", COORDINATE},
      {"max z", COORDINATE}},
     store_bounds_3d},
    {10,
     3,
     DUET_SHAPE_POSES,
     {{"cx", COORDINATE},
      {"cy", COORDINATE},
      {"cz", COORDINATE},
      {"hx", HALF},
      {"hy", HALF},
      {"hz", HALF},
      {"qx", ROTATION},
      {"qy", ROTATION},
      {"qz", ROTATION},
      {"qw", ROTATION}},
     store_pose_3d},
};

// What duet_scene_from_poses makes of a pose in 2D; in no file.
static const layout pose_2d = {6,
                               2,
                               DUET_SHAPE_POSES,
                               {{"cx", COORDINATE},
                                {"cy", COORDINATE},
                                {"hx", HALF},
                                {"hy", HALF},
                                {"qz", ROTATION},
                                {"qw", ROTATION}},
                               store_pose_2d};

static const layout *find_layout(uint32_t columns)
{
    for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; ++i)
        if (layouts[i].n == columns)
            return &layouts[i];
    return NULL;
}

// ------------------------------------------------------------------ checks

typedef struct place_text {
    char chars[320];
} place_text;

static place_text name_place(scene_place place)
{
    place_text t = {""};
    if (place.path && place.line > 0)
        snprintf(t.chars, sizeof t.chars, "%s:%llu: ", place.path, (unsigned long long)place.line);
    else if (place.path)
        snprintf(t.chars, sizeof t.chars, "%s: ", place.path);
    return t;
}

static bool refuse(const duet_scene *scene, scene_place place, duet_error *err, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

// BAD_OBJECT with the object's place and id before what is wrong.
static bool refuse(const duet_scene *scene, scene_place place, duet_error *err, const char *format,
                   ...)
{
    char what[128];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return error_set(err, DUET_BAD_OBJECT, "%sobject %u: %s", name_place(place).chars,
                     scene->info.n, what);
}

static bool check_number(const duet_scene *scene, const column *c, double value, scene_place place,
                         duet_error *err)
{
    if (!isfinite(value))
        return refuse(scene, place, err, "%s is %g; every number must be finite", c->name, value);
    bool stored_as_given = c->kind == COORDINATE || c->kind == HALF;
    if (stored_as_given && !isfinite((float)value))
        return refuse(scene, place, err, "%s = %g does not fit a 32-bit float (at most %g)",
                      c->name, value, (double)FLT_MAX);
    if (c->kind == HALF && value < 0)
        return refuse(scene, place, err, "%s = %g is negative; a half extent is 0 or more", c->name,
                      value);
    return true;
}

static bool check_corners(const duet_scene *scene, const layout *l, const double *row,
                          scene_place place, duet_error *err)
{
    for (uint32_t i = 0; i < l->dims; ++i)
        if (row[i] > row[i + l->dims])
            return refuse(scene, place, err, "%s = %g is above %s = %g", l->columns[i].name, row[i],
                          l->columns[i + l->dims].name, row[i + l->dims]);
    return true;
}

static bool check_rotation(const duet_scene *scene, const layout *l, const double *row,
                           scene_place place, duet_error *err)
{
    bool has_rotation = false;
    for (uint32_t i = 0; i < l->n; ++i) {
        if (l->columns[i].kind == ROTATION && row[i] != 0)
            return true;
        has_rotation = has_rotation || l->columns[i].kind == ROTATION;
    }
    return !has_rotation ||
           refuse(scene, place, err, "the quaternion is zero; 0 0 0 1 is no rotation");
}

static bool check_row(const duet_scene *scene, const layout *l, const double *row,
                      scene_place place, duet_error *err)
{
    for (uint32_t i = 0; i < l->n; ++i)
        if (!check_number(scene, &l->columns[i], row[i], place, err))
            return false;
    return l->shape == DUET_SHAPE_BOUNDS ? check_corners(scene, l, row, place, err)
                                         : check_rotation(scene, l, row, place, err);
}

// ----------------------------------------------------------------- filling

static size_t object_size(const duet_scene *scene)
{
    return scene->info.shape == DUET_SHAPE_POSES ? sizeof(duet_pose) : sizeof(duet_bounds);
}

bool scene_reserve(duet_scene *scene, uint64_t n, duet_error *err)
{
    if (n <= scene->room)
        return true;
    if (n > SCENE_MAX_OBJECTS)
        return error_set(err, DUET_TOO_MANY, "%llu objects; a scene holds at most %u",
                         (unsigned long long)n, SCENE_MAX_OBJECTS);
    void *objects = realloc(scene->objects, n * object_size(scene));
    if (!objects)
        return error_set(err, DUET_NO_MEMORY, "%llu objects of %zu bytes: no memory",
                         (unsigned long long)n, object_size(scene));
    scene->objects = objects;
    scene->room = n;
    return true;
}

static bool reserve_one_more(duet_scene *scene, duet_error *err)
{
    uint64_t n = (uint64_t)scene->info.n + 1;
    if (n <= scene->room)
        return true;
    uint64_t doubled = 2 * scene->room;
    if (doubled > SCENE_MAX_OBJECTS)
        doubled = SCENE_MAX_OBJECTS;
    return scene_reserve(scene, n > doubled ? n : doubled, err);
}

static bool add(duet_scene *scene, const layout *l, const double *row, scene_place place,
                duet_error *err)
{
    if (!check_row(scene, l, row, place, err) || !reserve_one_more(scene, err))
        return false;
    void *object = (char *)scene->objects + scene->info.n * object_size(scene);
    l->store(row, object);
    if (l->shape == DUET_SHAPE_POSES) {
        const float *q = ((const duet_pose *)object)->rotation;
        scene->info.rotated |= q[0] != 0 || q[1] != 0 || q[2] != 0;
    }
    ++scene->info.n;
    return true;
}

bool scene_add_row(duet_scene *scene, const double *row, scene_place place, duet_error *err)
{
    return add(scene, find_layout(scene->columns), row, place, err);
}

bool scene_set_columns(duet_scene *scene, uint32_t columns, scene_place place, duet_error *err)
{
    const layout *l = find_layout(columns);
    if (scene->columns != 0 && columns != scene->columns)
        return error_set(err, DUET_BAD_INPUT,
                         "%sobject %u has %u numbers, where those before it have %u",
                         name_place(place).chars, scene->info.n, columns, scene->columns);
    if (!l)
        return error_set(err, DUET_BAD_INPUT,
                         "%sobject %u has %u numbers; it must have " SCENE_COLUMNS,
                         name_place(place).chars, scene->info.n, columns);
    scene->columns = columns;
    scene->info.dims = l->dims;
    scene->info.shape = l->shape;
    return true;
}

bool scene_set_name(duet_scene *scene, const char *name, size_t length, duet_error *err)
{
    char *copy = malloc(length + 1);
    if (!copy)
        return error_set(err, DUET_NO_MEMORY, "a scene's name: no memory");
    memcpy(copy, name, length);
    copy[length] = '\0';
    free(scene->name);
    scene->name = copy;
    scene->info.name = copy;
    return true;
}

// ------------------------------------------------------------------ makers

// An empty scene, which is 3D poses until rows say otherwise.
static duet_scene *scene_new(duet_error *err)
{
    duet_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        error_set(err, DUET_NO_MEMORY, "a scene: no memory");
        return NULL;
    }
    scene->info.dims = 3;
    scene->info.shape = DUET_SHAPE_POSES;
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

static bool read_file(duet_scene *scene, const char *path, const duet_setting *settings,
                      uint32_t n_settings, duet_error *err)
{
    if (has_ending(path, ".lua"))
        return scene_read_lua(scene, path, settings, n_settings, err);
    if (n_settings > 0)
        return error_set(err, DUET_BAD_ARGUMENT,
                         "%s: '%s' is set, but only a .lua scene has parameters", path,
                         settings[0].name);
    return has_ending(path, ".npy") ? scene_read_npy(scene, path, err)
                                    : scene_read_text(scene, path, err);
}

duet_scene *duet_scene_load(const char *path, const duet_setting *settings, uint32_t n_settings,
                            duet_error *err)
{
    // Numbers have a decimal point whatever the application's language.
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    duet_scene *scene = plain ? scene_new(err) : NULL;
    bool ok = scene && name_after_file(scene, path, err) && scene_reserve(scene, 1, err);
    if (ok) {
        locale_t before = uselocale(plain);
        ok = read_file(scene, path, settings, n_settings, err);
        uselocale(before);
    }
    if (plain)
        freelocale(plain);
    else
        error_set(err, DUET_NO_MEMORY, "%s: no memory", path);
    return keep_if(ok, scene);
}

static duet_scene *start_copy(duet_shape shape, uint32_t n, uint32_t dims, duet_error *err)
{
    if (dims != 2 && dims != 3) {
        error_set(err, DUET_BAD_ARGUMENT, "dims is %u; it must be 2 or 3", dims);
        return NULL;
    }
    duet_scene *scene = scene_new(err);
    if (!scene)
        return NULL;
    scene->info.dims = dims;
    scene->info.shape = shape;
    return keep_if(scene_set_name(scene, "objects", strlen("objects"), err) &&
                       scene_reserve(scene, n > 0 ? n : 1, err),
                   scene);
}

duet_scene *duet_scene_from_poses(const duet_pose *poses, uint32_t n, uint32_t dims,
                                  duet_error *err)
{
    duet_scene *scene = start_copy(DUET_SHAPE_POSES, n, dims, err);
    const layout *l = dims == 2 ? &pose_2d : find_layout(10);
    bool ok = scene != NULL;
    for (uint32_t i = 0; ok && i < n; ++i) {
        const float *c = poses[i].centre;
        const float *h = poses[i].half;
        const float *q = poses[i].rotation;
        const double in_2d[] = {c[0], c[1], h[0], h[1], q[2], q[3]};
        const double in_3d[] = {c[0], c[1], c[2], h[0], h[1], h[2], q[0], q[1], q[2], q[3]};
        ok = add(scene, l, dims == 2 ? in_2d : in_3d, (scene_place){0}, err);
    }
    return keep_if(ok, scene);
}

duet_scene *duet_scene_from_bounds(const duet_bounds *bounds, uint32_t n, uint32_t dims,
                                   duet_error *err)
{
    duet_scene *scene = start_copy(DUET_SHAPE_BOUNDS, n, dims, err);
    const layout *l = find_layout(2 * dims);
    bool ok = scene != NULL;
    for (uint32_t i = 0; ok && i < n; ++i) {
        double row[6];
        for (uint32_t k = 0; k < dims; ++k) {
            row[k] = bounds[i].lower[k];
            row[k + dims] = bounds[i].upper[k];
        }
        ok = add(scene, l, row, (scene_place){0}, err);
    }
    return keep_if(ok, scene);
}

void duet_scene_destroy(duet_scene *scene)
{
    if (!scene)
        return;
    free(scene->objects);
    free(scene->name);
    free(scene);
}

// ----------------------------------------------------------------- reading

const duet_scene_info *duet_scene_describe(const duet_scene *scene)
{
    return &scene->info;
}

const duet_pose *duet_scene_poses(const duet_scene *scene)
{
    return scene->info.shape == DUET_SHAPE_POSES ? scene->objects : NULL;
}

const duet_bounds *duet_scene_bounds(const duet_scene *scene)
{
    return scene->info.shape == DUET_SHAPE_BOUNDS ? scene->objects : NULL;
}

duet_world_def duet_scene_world_def(const duet_scene *scene, duet_device_pair *pair)
{
    const duet_scene_info *info = &scene->info;
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.plan = duet_default_plan(pair);
    def.dims = info->dims;
    def.shape = info->shape;
    def.rotated = info->rotated;
    def.cell = info->cell;
    def.cell_fixed = info->cell_fixed;
    def.has_world = info->has_world;
    memcpy(def.lower, info->lower, sizeof def.lower);
    memcpy(def.upper, info->upper, sizeof def.upper);
    return def;
}
