// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/origin.h"

#include "base/error.h"
#include "runtime/narrowphase/narrow.h"

#include <math.h>
#include <string.h>

#define QUANTA 0x1p24 // of an edge
#define MOST_CELLS 0x1p30

bool origin_is_edge(float edge)
{
    int exponent;
    return edge == 0.0f || (frexpf(edge, &exponent) == 0.5f && exponent >= -99 && exponent <= 101);
}

uint32_t origin_setting(float edge)
{
    uint32_t bits;
    memcpy(&bits, &edge, sizeof bits);
    return bits >> 23;
}

static double to_quanta(double length, float edge)
{
    return rint(length * (QUANTA / (double)edge));
}

// The cell that counts from `cell` on, and the offset in it.
static bool put(float *offset, int32_t *in, int32_t cell, double quanta, float edge)
{
    double cells = floor(quanta / QUANTA);
    double sum = cells + cell;
    if (!(fabs(sum) < MOST_CELLS)) {
        *offset = NAN;
        *in = 0;
        return false;
    }
    *offset = (float)((quanta - cells * QUANTA) * (edge / QUANTA));
    *in = (int32_t)sum;
    return true;
}

bool origin_settle_at(float offset[3], int32_t cell[3], float edge)
{
    bool ok = true;
    for (int k = 0; k < 3; ++k)
        ok &= put(&offset[k], &cell[k], cell[k], to_quanta(offset[k], edge), edge);
    return ok;
}

bool origin_settle(duet_large_pose *large, float edge)
{
    return origin_settle_at(large->pose.centre, large->cell, edge);
}

bool origin_place(duet_large_pose *large, const double centre[3], float edge)
{
    bool ok = true;
    for (int k = 0; k < 3; ++k)
        ok &= put(&large->pose.centre[k], &large->cell[k], 0, to_quanta(centre[k], edge), edge);
    return ok;
}

size_t origin_row_bytes(duet_shape shape, float edge)
{
    static const size_t bytes[DUET_SHAPES] = {
        [DUET_SHAPE_POSES] = sizeof(duet_pose),
        [DUET_SHAPE_BOUNDS] = sizeof(duet_bounds),
        [DUET_SHAPE_ROUNDED_BOXES] = sizeof(duet_rounded_box),
        [DUET_SHAPE_SPHERES] = sizeof(duet_sphere),
    };
    return edge > 0.0f ? sizeof(duet_large_pose) : bytes[shape];
}

duet_object_kind origin_row_kind(duet_shape shape, float edge)
{
    static const duet_object_kind kinds[DUET_SHAPES] = {
        [DUET_SHAPE_POSES] = DUET_OBJECT_POSES,
        [DUET_SHAPE_BOUNDS] = DUET_OBJECT_BOUNDS,
        [DUET_SHAPE_ROUNDED_BOXES] = DUET_OBJECT_ROUNDED_BOXES,
        [DUET_SHAPE_SPHERES] = DUET_OBJECT_SPHERES,
    };
    return shape == DUET_SHAPE_POSES && edge > 0.0f ? DUET_OBJECT_LARGE_POSES : kinds[shape];
}

// ---------------------------------------------------------------- for callers

bool duet_large_pose_set(duet_large_pose *large, const double centre[3], float edge,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(large, __func__, "pose", err) || !error_given(centre, __func__, "centre", err))
        return false;
    if (!(edge > 0.0f) || !origin_is_edge(edge))
        return bad_argument(
            err, "the origin cells' edge is %g; expected a power of two from 2^-100 to 2^100",
            (double)edge);
    return origin_place(large, centre, edge) ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "the centre %g %g %g is not a number or beyond 2^30 origin cells of edge %g",
                     centre[0], centre[1], centre[2], (double)edge);
}

// Both settled, and from one cell to the other.
static bool settle_both(duet_large_pose both[2], double shift[3], float edge)
{
    bool ok = origin_settle(&both[0], edge) && origin_settle(&both[1], edge);
    origin_shift(shift, both, edge, 0, 1);
    return ok;
}

static bool can_meet(const duet_large_pose *a, const duet_large_pose *b, float edge, uint32_t dims)
{
    return a && b && edge > 0.0f && origin_is_edge(edge) && (dims == 2 || dims == 3);
}

bool duet_large_poses_collide(const duet_large_pose *a, const duet_large_pose *b, float edge,
                              uint32_t dims)
{
    if (!can_meet(a, b, edge, dims))
        return false;
    duet_large_pose both[2] = {*a, *b};
    double shift[3];
    return settle_both(both, shift, edge) && narrow_is_box(&both[0].pose, dims) &&
           narrow_is_box(&both[1].pose, dims) &&
           narrow_decide_apart(&both[0].pose, &both[1].pose, shift, dims);
}

double duet_large_poses_separation(const duet_large_pose *a, const duet_large_pose *b, float edge,
                                   uint32_t dims)
{
    if (!can_meet(a, b, edge, dims))
        return NAN;
    duet_large_pose both[2] = {*a, *b};
    double shift[3];
    return settle_both(both, shift, edge)
               ? narrow_widest_separation(&both[0].pose, &both[1].pose, shift, dims)
               : NAN;
}
