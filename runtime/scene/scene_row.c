// SPDX-License-Identifier: MIT
// What an object may be, whoever brings it.
//
// Numbers arrive in double and are rounded to the nearest float once, after
// the checks, so that a negative extent too small for float is still refused.
#include "runtime/scene/scene_row.h"

#include "base/error.h"

#include <float.h>
#include <inttypes.h>
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

// Nearly every quaternion: floats hold it, and its squares, as it is.
static bool is_ordinary(const double *q, int n)
{
    double greatest = 0;
    bool held = true;
    for (int i = 0; i < n; ++i) {
        double size = fabs(q[i]);
        greatest = size > greatest ? size : greatest;
        held = held && (size == 0 || size >= FLT_MIN);
    }
    return held && greatest >= 0x1p-32 && greatest <= 0x1p32;
}

// The exponent of the greatest part once it is rounded to a float's 24 bits, as frexp counts.
static int exponent_of(const double *q, int n)
{
    double greatest = 0;
    for (int i = 0; i < n; ++i)
        greatest = fmax(greatest, fabs(q[i]));
    int exponent, carry;
    frexp((float)frexp(greatest, &exponent), &carry);
    return exponent + carry;
}

// Whether a float has all its 24 bits for a part times 2^shift, or those there are.
static bool keeps_part(double part, int shift)
{
    double scaled = ldexp(part, shift);
    float kept = (float)scaled;
    return (fabs(scaled) >= FLT_MIN && isfinite(kept)) || ldexp((double)kept, -shift) == part;
}

// The power of two by which a quaternion is multiplied: its length does not count,
// but devices square it in float, so one that is very short or long is brought
// near 1. If that would take bits from a part it is made as long as floats are,
// which leaves every quaternion of floats as it is.
static int shift_of(const double q[4])
{
    if (is_ordinary(q, 4))
        return 0;
    int exponent = exponent_of(q, 4);
    int shift = exponent < -32 || exponent > 32 ? -exponent : 0;
    for (int i = 0; i < 4; ++i)
        if (!keeps_part(q[i], shift))
            return FLT_MAX_EXP - exponent;
    return shift;
}

static void store_rotation(double x, double y, double z, double w, duet_pose *pose)
{
    const double q[4] = {x, y, z, w};
    int shift = shift_of(q);
    for (int i = 0; i < 4; ++i)
        pose->rotation[i] = (float)ldexp(q[i], shift);
}

static void store_pose_2d(const double *row, void *object)
{
    duet_pose *pose = object;
    *pose = (duet_pose){
        .centre = {(float)row[0], (float)row[1]},
        .half_extents = {(float)row[2], (float)row[3]},
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
        .half_extents = {(float)row[3], (float)row[4], (float)row[5]},
    };
    store_rotation(row[6], row[7], row[8], row[9], pose);
}

static const scene_column bounds_2d[] = {{"min x", COLUMN_COORDINATE},
                                         {"min y", COLUMN_COORDINATE},
                                         {"max x", COLUMN_COORDINATE},
                                         {"max y", COLUMN_COORDINATE}};
static const scene_column bounds_3d[] = {
    {"min x", COLUMN_COORDINATE}, {"min y", COLUMN_COORDINATE}, {"min z", COLUMN_COORDINATE},
    {"max x", COLUMN_COORDINATE}, {"max y", COLUMN_COORDINATE}, {"max z", COLUMN_COORDINATE}};
static const scene_column box_2d[] = {{"cx", COLUMN_COORDINATE},
                                      {"cy", COLUMN_COORDINATE},
                                      {"hx", COLUMN_HALF},
                                      {"hy", COLUMN_HALF},
                                      {"angle", COLUMN_ANGLE}};

// The last is only of a rounded box, here and below.
static const scene_column pose_2d[] = {{"cx", COLUMN_COORDINATE}, {"cy", COLUMN_COORDINATE},
                                       {"hx", COLUMN_HALF},       {"hy", COLUMN_HALF},
                                       {"qz", COLUMN_ROTATION},   {"qw", COLUMN_ROTATION},
                                       {"radius", COLUMN_RADIUS}};
static const scene_column pose_3d[] = {
    {"cx", COLUMN_COORDINATE}, {"cy", COLUMN_COORDINATE}, {"cz", COLUMN_COORDINATE},
    {"hx", COLUMN_HALF},       {"hy", COLUMN_HALF},       {"hz", COLUMN_HALF},
    {"qx", COLUMN_ROTATION},   {"qy", COLUMN_ROTATION},   {"qz", COLUMN_ROTATION},
    {"qw", COLUMN_ROTATION},   {"radius", COLUMN_RADIUS}};

// The rows that files have. No two have the same number of columns.
static const scene_layout layouts[] = {
    {4, 2, DUET_SHAPE_BOUNDS, bounds_2d, store_bounds_2d},
    {5, 2, DUET_SHAPE_POSES, box_2d, store_box_2d},
    {6, 3, DUET_SHAPE_BOUNDS, bounds_3d, store_bounds_3d},
    {7, 2, DUET_SHAPE_POSES, pose_2d, store_pose_2d},
    {10, 3, DUET_SHAPE_POSES, pose_3d, store_pose_3d},
    {11, 3, DUET_SHAPE_POSES, pose_3d, store_pose_3d},
};

// The row of a 2D pose from duet_scene_create; in no file.
const scene_layout scene_layout_pose_2d = {6, 2, DUET_SHAPE_POSES, pose_2d, store_pose_2d};

const scene_layout *scene_layout_find(uint32_t columns)
{
    for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; ++i)
        if (layouts[i].n == columns)
            return &layouts[i];
    return NULL;
}

const scene_layout *scene_layout_rounded_box(uint32_t dims)
{
    return scene_layout_find(dims == 2 ? 7 : 11);
}

bool scene_layout_has_radius(const scene_layout *l)
{
    return l->columns[l->n - 1].kind == COLUMN_RADIUS;
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

// "boxes.csv:17: object 14", "pairs.npy: pair 3, second pose"
static scene_place_text scene_place_object(scene_place place, uint64_t id)
{
    scene_place_text t = scene_place_name(place);
    size_t length = strlen(t.chars);
    char *rest = t.chars + length;
    if (place.in_pairs)
        snprintf(rest, sizeof t.chars - length, "pair %" PRIu64 ", %s pose", id / 2,
                 id % 2 ? "second" : "first");
    else
        snprintf(rest, sizeof t.chars - length, "object %" PRIu64, id);
    return t;
}

static bool refuse(uint64_t id, scene_place place, duet_error *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

// BAD_OBJECT with the object's place and id before what is wrong.
static bool refuse(uint64_t id, scene_place place, duet_error *err, const char *format, ...)
{
    char what[128];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return error_set(err, DUET_STATUS_BAD_OBJECT, "%s: %s", scene_place_object(place, id).chars,
                     what);
}

static bool check_number(const scene_column *c, double value, uint64_t id, scene_place place,
                         duet_error *err)
{
    if (!isfinite(value))
        return refuse(id, place, err, "%s is %g; every number must be finite", c->name, value);
    bool stored_as_given = c->kind != COLUMN_ANGLE && c->kind != COLUMN_ROTATION;
    if (stored_as_given && !isfinite((float)value))
        return refuse(id, place, err, "%s = %g does not fit a 32-bit float (at most %g)", c->name,
                      value, (double)FLT_MAX);
    if (c->kind == COLUMN_HALF && value < 0)
        return refuse(id, place, err, "%s = %g is negative; a half extent is 0 or more", c->name,
                      value);
    if (c->kind == COLUMN_RADIUS && value < 0)
        return refuse(id, place, err, "%s = %g is negative; a radius is 0 or more", c->name, value);
    return true;
}

static bool check_corners(const scene_layout *l, const double *row, uint64_t id, scene_place place,
                          duet_error *err)
{
    for (uint32_t i = 0; i < l->dims; ++i)
        if (row[i] > row[i + l->dims])
            return refuse(id, place, err, "%s = %g is above %s = %g", l->columns[i].name, row[i],
                          l->columns[i + l->dims].name, row[i + l->dims]);
    return true;
}

// The greatest ratio of two parts that floats hold, as a power of two, and the
// half of the least float, which is rounded to 0.
#define WIDEST_RATIO 276
#define HALF_OF_LEAST 0x1p-150

static bool check_quaternion(const scene_column *columns, const double *q, int n, uint64_t id,
                             scene_place place, duet_error *err)
{
    if (is_ordinary(q, n))
        return true;
    int longest = FLT_MAX_EXP - exponent_of(q, n);
    bool zero = true;
    for (int i = 0; i < n; ++i) {
        zero = zero && q[i] == 0;
        if (q[i] != 0 && ldexp(fabs(q[i]), longest) <= HALF_OF_LEAST)
            return refuse(id, place, err,
                          "%s = %g vanishes beside the quaternion's greatest part; expected a "
                          "ratio of at most %.0e",
                          columns[i].name, q[i], ldexp(1, WIDEST_RATIO));
    }
    return !zero || refuse(id, place, err, "the quaternion is zero; 0 0 0 1 is no rotation");
}

// The half of an angle near 0 is its sine, beside a cosine of 1.
static bool check_angle(double angle, uint64_t id, scene_place place, duet_error *err)
{
    double least = ldexp(1, 1 - WIDEST_RATIO);
    return angle == 0 || fabs(angle) >= least ||
           refuse(id, place, err, "angle = %g is too near 0; expected 0, or %.0e or more", angle,
                  least);
}

static bool check_rotation(const scene_layout *l, const double *row, uint64_t id, scene_place place,
                           duet_error *err)
{
    uint32_t from = 2 * l->dims; // after centre and half extents
    return l->columns[from].kind == COLUMN_ANGLE
               ? check_angle(row[from], id, place, err)
               : check_quaternion(&l->columns[from], row + from, l->dims == 2 ? 2 : 4, id, place,
                                  err);
}

bool scene_row_check(const scene_layout *l, const double *row, uint64_t id, scene_place place,
                     duet_error *err)
{
    for (uint32_t i = 0; i < l->n; ++i)
        if (!check_number(&l->columns[i], row[i], id, place, err))
            return false;
    return l->shape == DUET_SHAPE_BOUNDS ? check_corners(l, row, id, place, err)
                                         : check_rotation(l, row, id, place, err);
}
