// SPDX-License-Identifier: MIT
// What an object may be, whoever brings it.
//
// Numbers arrive in double and are rounded to the nearest float once, after
// the checks, so that a negative extent too small for float is still refused.
#include "runtime/scene_row.h"

#include "runtime/base/error.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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
static const scene_layout layouts[] = {
    {4,
     2,
     DUET_SHAPE_BOUNDS,
     {{"min x", COLUMN_COORDINATE},
      {"min y", COLUMN_COORDINATE},
      {"max x", COLUMN_COORDINATE},
      {"max y", COLUMN_COORDINATE}},
     store_bounds_2d},
    {5,
     2,
     DUET_SHAPE_POSES,
     {{"cx", COLUMN_COORDINATE},
      {"cy", COLUMN_COORDINATE},
      {"hx", COLUMN_HALF},
      {"hy", COLUMN_HALF},
      {"angle", COLUMN_ANGLE}},
     store_box_2d},
    {6,
     3,
     DUET_SHAPE_BOUNDS,
     {{"min x", COLUMN_COORDINATE},
      {"min y", COLUMN_COORDINATE},
      {"min z", COLUMN_COORDINATE},
      {"max x", COLUMN_COORDINATE},
      {"max y", COLUMN_COORDINATE},
      {"max z", COLUMN_COORDINATE}},
     store_bounds_3d},
    {10,
     3,
     DUET_SHAPE_POSES,
     {{"cx", COLUMN_COORDINATE},
      {"cy", COLUMN_COORDINATE},
      {"cz", COLUMN_COORDINATE},
      {"hx", COLUMN_HALF},
      {"hy", COLUMN_HALF},
      {"hz", COLUMN_HALF},
      {"qx", COLUMN_ROTATION},
      {"qy", COLUMN_ROTATION},
      {"qz", COLUMN_ROTATION},
      {"qw", COLUMN_ROTATION}},
     store_pose_3d},
};

// What duet_scene_from_poses makes of a pose in 2D; in no file.
const scene_layout scene_layout_pose_2d = {6,
                                           2,
                                           DUET_SHAPE_POSES,
                                           {{"cx", COLUMN_COORDINATE},
                                            {"cy", COLUMN_COORDINATE},
                                            {"hx", COLUMN_HALF},
                                            {"hy", COLUMN_HALF},
                                            {"qz", COLUMN_ROTATION},
                                            {"qw", COLUMN_ROTATION}},
                                           store_pose_2d};

const scene_layout *scene_layout_find(uint32_t columns)
{
    for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; ++i)
        if (layouts[i].n == columns)
            return &layouts[i];
    return NULL;
}

// ------------------------------------------------------------------ checks

scene_place_text scene_place_name(scene_place place)
{
    scene_place_text t = {""};
    if (place.path && place.line > 0)
        snprintf(t.chars, sizeof t.chars, "%s:%llu: ", place.path, (unsigned long long)place.line);
    else if (place.path)
        snprintf(t.chars, sizeof t.chars, "%s: ", place.path);
    return t;
}

scene_place_text scene_place_object(scene_place place, uint32_t id)
{
    scene_place_text t = scene_place_name(place);
    size_t length = strlen(t.chars);
    char *rest = t.chars + length;
    if (place.in_pairs)
        snprintf(rest, sizeof t.chars - length, "pair %u, %s pose", id / 2,
                 id % 2 ? "second" : "first");
    else
        snprintf(rest, sizeof t.chars - length, "object %u", id);
    return t;
}

static bool refuse(uint32_t id, scene_place place, duet_error *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

// BAD_OBJECT with the object's place and id before what is wrong.
static bool refuse(uint32_t id, scene_place place, duet_error *err, const char *format, ...)
{
    char what[128];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return error_set(err, DUET_BAD_OBJECT, "%s: %s", scene_place_object(place, id).chars, what);
}

static bool check_number(const scene_column *c, double value, uint32_t id, scene_place place,
                         duet_error *err)
{
    if (!isfinite(value))
        return refuse(id, place, err, "%s is %g; every number must be finite", c->name, value);
    bool stored_as_given = c->kind == COLUMN_COORDINATE || c->kind == COLUMN_HALF;
    if (stored_as_given && !isfinite((float)value))
        return refuse(id, place, err, "%s = %g does not fit a 32-bit float (at most %g)", c->name,
                      value, (double)FLT_MAX);
    if (c->kind == COLUMN_HALF && value < 0)
        return refuse(id, place, err, "%s = %g is negative; a half extent is 0 or more", c->name,
                      value);
    return true;
}

static bool check_corners(const scene_layout *l, const double *row, uint32_t id, scene_place place,
                          duet_error *err)
{
    for (uint32_t i = 0; i < l->dims; ++i)
        if (row[i] > row[i + l->dims])
            return refuse(id, place, err, "%s = %g is above %s = %g", l->columns[i].name, row[i],
                          l->columns[i + l->dims].name, row[i + l->dims]);
    return true;
}

static bool check_rotation(const scene_layout *l, const double *row, uint32_t id, scene_place place,
                           duet_error *err)
{
    bool has_rotation = false;
    for (uint32_t i = 0; i < l->n; ++i) {
        if (l->columns[i].kind == COLUMN_ROTATION && row[i] != 0)
            return true;
        has_rotation = has_rotation || l->columns[i].kind == COLUMN_ROTATION;
    }
    return !has_rotation ||
           refuse(id, place, err, "the quaternion is zero; 0 0 0 1 is no rotation");
}

bool scene_row_check(const scene_layout *l, const double *row, uint32_t id, scene_place place,
                     duet_error *err)
{
    for (uint32_t i = 0; i < l->n; ++i)
        if (!check_number(&l->columns[i], row[i], id, place, err))
            return false;
    return l->shape == DUET_SHAPE_BOUNDS ? check_corners(l, row, id, place, err)
                                         : check_rotation(l, row, id, place, err);
}
