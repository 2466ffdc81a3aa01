// SPDX-License-Identifier: MIT
#include "runtime/broadphase/grid_objects.h"

#include "base/compare.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

duet_transform grid_transform_of(const duet_pose *pose)
{
    duet_transform t;
    memcpy(t.centre, pose->centre, sizeof t.centre);
    memcpy(t.rotation, pose->rotation, sizeof t.rotation);
    return t;
}

static const void *row_of(const grid_objects *objects, uint32_t id)
{
    return (const char *)objects->all.rows + id * objects->all.row_bytes;
}

const duet_pose *grid_pose_of(const grid_objects *objects, uint32_t id, duet_pose *scratch)
{
    const void *row = row_of(objects, id);
    if (objects->shape != DUET_SHAPE_SPHERES && !objects->sizes.rows)
        return row;
    *scratch = (duet_pose){.rotation = {0, 0, 0, 1}};
    memcpy(scratch->centre, row, sizeof scratch->centre);
    if (objects->shape == DUET_SHAPE_SPHERES)
        return scratch;
    const duet_size *size = (const duet_size *)objects->sizes.rows + id;
    const bool compact = objects->kind == DUET_OBJECT_COMPACT_TRANSFORMS;
    memcpy(scratch->half_extents, size->half_extents, sizeof scratch->half_extents);
    if (!compact)
        memcpy(scratch->rotation, ((const duet_transform *)row)->rotation,
               sizeof scratch->rotation);
    for (int k = 0; compact && k < 4; ++k)
        scratch->rotation[k] = ((const duet_compact_transform *)row)->rotation[k];
    return scratch;
}

float grid_radius_of(const grid_objects *objects, uint32_t id)
{
    return objects->shape == DUET_SHAPE_ROUNDED_BOXES
               ? ((const duet_rounded_box *)objects->all.rows)[id].radius
           : objects->shape == DUET_SHAPE_SPHERES
               ? ((const duet_sphere *)objects->all.rows)[id].radius
               : 0.0f;
}

// An object that has a radius.
static duet_rounded_box rounded_box_of(const grid_objects *objects, uint32_t id)
{
    return objects->shape == DUET_SHAPE_SPHERES
               ? rounded_of_sphere(&((const duet_sphere *)objects->all.rows)[id])
               : ((const duet_rounded_box *)objects->all.rows)[id];
}

// The point that decides an object\'s cell; z is 0 in 2D.
static void point_of(double at[3], const grid_objects *objects, uint32_t id)
{
    const void *row = row_of(objects, id);
    at[2] = 0.0;
    for (uint32_t k = 0; k < objects->dims; ++k)
        at[k] = (double)((const float *)row)[k];
    for (uint32_t k = 0; objects->origin > 0.0f && k < objects->dims; ++k)
        at[k] += (double)((const duet_large_pose *)row)->cell[k] * objects->origin;
}

void grid_centre_of(double centre[3], const grid_objects *objects, uint32_t id)
{
    point_of(centre, objects, id);
    if (objects->shape != DUET_SHAPE_BOUNDS)
        return;
    const duet_bounds *b = &((const duet_bounds *)objects->all.rows)[id];
    for (uint32_t k = 0; k < objects->dims; ++k)
        centre[k] = 0.5 * (centre[k] + (double)b->upper[k]);
}

bool grid_objects_collide(const grid_objects *objects, uint32_t a, uint32_t b)
{
    if (grid_has_radii(objects)) {
        const duet_rounded_box of_a = rounded_box_of(objects, a);
        const duet_rounded_box of_b = rounded_box_of(objects, b);
        return rounded_decide(&of_a, &of_b, objects->dims);
    }
    double shift[3];
    duet_pose scratch[2];
    const duet_pose *of_a = grid_pose_of(objects, a, &scratch[0]);
    const duet_pose *of_b = grid_pose_of(objects, b, &scratch[1]);
    origin_shift(shift, objects->all.rows, objects->origin, a, b);
    return narrow_decide_apart(of_a, of_b, shift, objects->dims);
}

// ---------------------------------------------------------------- needs: where objects are, how wide

// The octave of an extent, 2^-150 .. 2^149, as frexp counts; points share the
// lowest.
static uint32_t octave_of(double extent)
{
    enum { EXPONENT_AT = 52, EXPONENT_OF_HALF = 1022 };
    uint64_t bits;
    memcpy(&bits, &extent, sizeof bits);
    int exponent = extent > 0.0 ? (int)(bits >> EXPONENT_AT) - EXPONENT_OF_HALF : -GRID_OCTAVES;
    if (exponent < -GRID_OCTAVES / 2)
        exponent = -GRID_OCTAVES / 2;
    if (exponent >= GRID_OCTAVES / 2)
        exponent = GRID_OCTAVES / 2 - 1;
    return (uint32_t)(exponent + GRID_OCTAVES / 2);
}

static void add(grid_needs *needs, const double point[3], double widest, double rounding,
                uint32_t id)
{
    for (int k = 0; k < 3; ++k) {
        needs->lower[k] = lesser(needs->lower[k], point[k]);
        needs->upper[k] = greater(needs->upper[k], point[k]);
    }
    if (widest > needs->widest) {
        needs->widest = widest;
        needs->widest_id = id;
    }
    double in_float = widest + rounding;
    uint32_t octave = octave_of(in_float);
    ++needs->octave_n[octave];
    needs->octave_widest[octave] = greater(needs->octave_widest[octave], in_float);
}

// The widest extent of the rotated box: rows of |M(q)| / |q|^2 times the half
// extents, twice.
static double widest_of_pose(const duet_pose *p, uint32_t dims)
{
    double x = dims == 3 ? p->rotation[0] : 0.0;
    double y = dims == 3 ? p->rotation[1] : 0.0;
    double z = p->rotation[2];
    double w = p->rotation[3];
    double hx = p->half_extents[0];
    double hy = p->half_extents[1];
    double hz = dims == 3 ? p->half_extents[2] : 0.0;
    double scale = 2.0 / (x * x + y * y + z * z + w * w);
    double rx = fabs(w * w + x * x - y * y - z * z) * hx + 2.0 * fabs(x * y - w * z) * hy +
                2.0 * fabs(x * z + w * y) * hz;
    double ry = 2.0 * fabs(x * y + w * z) * hx + fabs(w * w - x * x + y * y - z * z) * hy +
                2.0 * fabs(y * z - w * x) * hz;
    double rz = 2.0 * fabs(x * z - w * y) * hx + 2.0 * fabs(y * z + w * x) * hy +
                fabs(w * w - x * x - y * y + z * z) * hz;
    double widest = greater(rx, ry);
    return scale * (dims == 3 ? greater(widest, rz) : widest);
}

// Below 0 if a corner lies before the other: no box.
static double widest_of_bounds(const duet_bounds *b, uint32_t dims)
{
    double widest = 0.0, narrowest = 0.0;
    for (uint32_t k = 0; k < dims; ++k) {
        double along = (double)b->upper[k] - (double)b->lower[k];
        widest = greater(widest, along);
        narrowest = lesser(narrowest, along);
    }
    return narrowest < 0.0 ? narrowest : widest;
}

// The part that the rounding of a device's bounds adds to an extent
// (kernels/narrowphase/object.clh, object_extent): on either side three roundings of a corner and
// 2^-23 of it.
static inline double rounding_of_pose(const duet_pose *p, const grid_objects *objects)
{
    double farthest = 0.0;
    for (uint32_t k = 0; k < objects->dims; ++k)
        farthest = greater(farthest, fabs((double)p->centre[k]));
    return 0x1.8p-21 * farthest + 0x1p-23 * (double)objects->origin + 0x1p-123;
}

static double widest_of(const grid_objects *objects, uint32_t id, double *rounding)
{
    duet_pose scratch;
    *rounding = 0.0;
    if (objects->shape == DUET_SHAPE_BOUNDS)
        return widest_of_bounds(&((const duet_bounds *)objects->all.rows)[id], objects->dims);
    const duet_pose *pose = grid_pose_of(objects, id, &scratch);
    *rounding = rounding_of_pose(pose, objects);
    double radius = grid_radius_of(objects, id);
    double widest = widest_of_pose(pose, objects->dims) + 2.0 * radius;
    return radius < 0.0 ? radius : widest;
}

static void add_some(grid_needs *needs, const grid_objects *objects, uint32_t first, uint32_t last)
{
    *needs = (grid_needs){.lower = {INFINITY, INFINITY, INFINITY},
                          .upper = {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t id = first; id < last; ++id) {
        double point[3] = {0};
        point_of(point, objects, id);
        double rounding;
        double widest = widest_of(objects, id, &rounding);
        if (isfinite(point[0] + point[1] + point[2] + widest) && widest >= 0.0)
            add(needs, point, widest, rounding, id);
    }
}

// Adds the needs of objects behind all that there are.
static void join(grid_needs *needs, const grid_needs *more)
{
    for (int k = 0; k < 3; ++k) {
        needs->lower[k] = lesser(needs->lower[k], more->lower[k]);
        needs->upper[k] = greater(needs->upper[k], more->upper[k]);
    }
    if (more->widest > needs->widest) {
        needs->widest = more->widest;
        needs->widest_id = more->widest_id;
    }
    for (uint32_t k = 0; k < GRID_OCTAVES; ++k) {
        needs->octave_n[k] += more->octave_n[k];
        needs->octave_widest[k] = greater(needs->octave_widest[k], more->octave_widest[k]);
    }
}

// Pieces of many objects, which threads take one after the other.
enum { PIECES = 128 };

typedef struct pieces {
    const grid_objects *objects;
    grid_needs needs[PIECES];
} pieces;

static void add_pieces(void *arg, uint64_t first, uint64_t last)
{
    pieces *p = arg;
    for (uint64_t i = first; i < last; ++i)
        add_some(&p->needs[i], p->objects, (uint32_t)(p->objects->all.n * i / PIECES),
                 (uint32_t)(p->objects->all.n * (i + 1) / PIECES));
}

void grid_needs_of(grid_needs *needs, const grid_objects *objects, thread_pool *threads)
{
    pieces *p = threads ? malloc(sizeof *p) : NULL;
    if (!p) {
        add_some(needs, objects, 0, objects->all.n);
        return;
    }
    p->objects = objects;
    thread_pool_share(threads, add_pieces, p, PIECES, 1);
    *needs = p->needs[0];
    for (uint32_t i = 1; i < PIECES; ++i)
        join(needs, &p->needs[i]);
    free(p);
}
