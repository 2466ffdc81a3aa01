// SPDX-License-Identifier: MIT
#include "cluster/object.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>

// Beyond what the devices round: parts of a box's size, which they widen by less than 2^-17;
// of its coordinates as floats, and what they add to 0; and of an origin cell, whose corners lie up
// to 2^30 edges from 0.
#define SIZE_SLACK 0x1p-12
#define FLOAT_SLACK 0x1p-20
#define LEAST_SLACK 0x1p-124
#define ORIGIN_SLACK 0x1p-20

object_form object_form_of(const duet_world_def *def)
{
    return (object_form){
        .dims = def->dims,
        .shape = def->shape,
        .rotated = def->rotated,
        .origin = def->origin_edge,
        .bytes = (uint32_t)origin_row_bytes(def->shape, def->origin_edge),
    };
}

duet_object_kind object_form_kind(const object_form *form)
{
    return origin_row_kind(form->shape, form->origin);
}

// Rows begin with a centre, unless they are bounds.
static const float *centre_of(const void *object)
{
    return object;
}

static double radius_of(const object_form *form, const void *object)
{
    return form->shape == DUET_SHAPE_ROUNDED_BOXES
               ? (double)((const duet_rounded_box *)object)->radius
           : form->shape == DUET_SHAPE_SPHERES ? (double)((const duet_sphere *)object)->radius
                                               : 0;
}

static void widen(extent *r, const double slack[3], uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k) {
        r->lower[k] -= slack[k];
        r->upper[k] += slack[k];
    }
}

double object_slack(const object_form *form, double half, double coordinate)
{
    return SIZE_SLACK * half + FLOAT_SLACK * fabs(coordinate) +
           ORIGIN_SLACK * (double)form->origin + LEAST_SLACK;
}

// Returns an extent around the bounding sphere if boxes are rotated: the ranks that need an object
// are decided faster than its bounds are found.
static extent extent_of_pose(const object_form *form, const void *object)
{
    const duet_pose *p = object_pose(form, object);
    double corner[3], half[3], slack[3], squares = 0, radius = radius_of(form, object);
    extent r = {{0}, {0}};
    origin_corner(corner, object, form->origin, 0);
    for (uint32_t k = 0; k < form->dims; ++k) {
        half[k] = p ? (double)p->half_extents[k] : 0;
        squares += half[k] * half[k];
    }
    double around = sqrt(squares);
    for (uint32_t k = 0; k < form->dims; ++k) {
        double centre = (double)centre_of(object)[k];
        double to = (form->rotated ? around : half[k]) + radius;
        r.lower[k] = corner[k] + (centre - to);
        r.upper[k] = corner[k] + (centre + to);
        slack[k] = object_slack(form, around + radius, centre);
    }
    widen(&r, slack, form->dims);
    return r;
}

extent extent_of(const object_form *form, const void *object)
{
    if (form->shape != DUET_SHAPE_BOUNDS)
        return extent_of_pose(form, object);
    const duet_bounds *b = object;
    extent r = {{0}, {0}};
    for (uint32_t k = 0; k < form->dims; ++k) {
        r.lower[k] = (double)b->lower[k];
        r.upper[k] = (double)b->upper[k];
    }
    return r;
}

void object_centre(const object_form *form, const void *object, double centre[3])
{
    double corner[3] = {0, 0, 0};
    const duet_bounds *b = form->shape == DUET_SHAPE_BOUNDS ? object : NULL;
    origin_corner(corner, object, form->origin, 0);
    centre[2] = 0;
    for (uint32_t k = 0; k < form->dims; ++k)
        centre[k] = b ? 0.5 * ((double)b->lower[k] + (double)b->upper[k])
                      : corner[k] + (double)centre_of(object)[k];
}

double object_half(const object_form *form, const void *object)
{
    const duet_pose *core = object_pose(form, object);
    double squares = 0;
    if (form->shape == DUET_SHAPE_BOUNDS) {
        extent e = extent_of(form, object);
        return 0.5 * extent_widest(&e);
    }
    for (uint32_t k = 0; core && k < form->dims; ++k)
        squares += (double)core->half_extents[k] * (double)core->half_extents[k];
    return sqrt(squares) + radius_of(form, object);
}

// Sound in 3D, found without a branch for each number; a flat box may be sound if that says no.
static bool is_plainly_sound(const duet_pose *p)
{
    const float *c = p->centre, *h = p->half_extents, *q = p->rotation;
    float zero = 0.0f * (c[0] + c[1] + c[2]) + 0.0f * (h[0] + h[1] + h[2]) +
                 0.0f * (q[0] + q[1] + q[2] + q[3]);
    float least = h[0] < h[1] ? h[0] : h[1];
    least = h[2] < least ? h[2] : least;
    return zero == 0.0f && least >= 0.0f && (q[2] != 0.0f || q[3] != 0.0f);
}

static bool are_sound_bounds(const duet_bounds *b, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        if (!isfinite(b->lower[k]) || !isfinite(b->upper[k]) || b->lower[k] > b->upper[k])
            return false;
    return true;
}

static bool is_finite_point(const float *centre, uint32_t dims)
{
    float zero = 0.0f;
    for (uint32_t k = 0; k < dims; ++k)
        zero += 0.0f * centre[k];
    return zero == 0.0f;
}

bool object_is_sound(const object_form *form, const void *object)
{
    if (form->shape == DUET_SHAPE_BOUNDS)
        return are_sound_bounds(object, form->dims);
    const duet_pose *p = object_pose(form, object);
    double radius = radius_of(form, object);
    return radius >= 0 && isfinite(radius) &&
           (p ? is_plainly_sound(p) || narrow_is_box(p, form->dims)
              : is_finite_point(centre_of(object), form->dims));
}
