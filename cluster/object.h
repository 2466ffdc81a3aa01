// SPDX-License-Identifier: MIT
// One object: its form, where it is, how far it reaches, and whether it is sound.
#ifndef CLUSTER_OBJECT_H
#define CLUSTER_OBJECT_H

#include "runtime/duet.h"

// The form of all ranks' objects.
typedef struct object_form {
    uint32_t dims;
    duet_shape shape;
    bool rotated;
    float origin;   // the edge of origin cells, or 0
    uint32_t bytes; // the size of an object
} object_form;

object_form object_form_of(const duet_world_def *def);
duet_object_kind object_form_kind(const object_form *form);

// Bounds that contain all that the devices or the reference take for the object's, however a
// box is turned, and in 2D 0 along z.
typedef struct extent {
    double lower[3];
    double upper[3];
} extent;

extern const extent extent_none; // contains nothing
extent extent_of(const object_form *form, const void *object);
void extent_join(extent *to, const extent *other);
bool extents_meet(const extent *a, const extent *b);
// Whether a point lies inside, and not on its surface.
static inline bool extent_holds(const extent *r, const double point[3])
{
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside &= (point[k] > r->lower[k]) & (point[k] < r->upper[k]);
    return inside;
}
double extent_widest(const extent *e);

// The point that decides which domain an object belongs to.
void object_centre(const object_form *form, const void *object, double centre[3]);
bool object_is_sound(const object_form *form, const void *object);

// A pose, or the core of what has a radius. NULL of spheres, which have none.
static inline const duet_pose *object_pose(const object_form *form, const void *object)
{
    return form->shape == DUET_SHAPE_SPHERES ? NULL : object;
}

// Half the width of a sound object, before rounding; and how far an extent may reach beyond that,
// of an object of such a half width and such a coordinate.
double object_half(const object_form *form, const void *object);
double object_slack(const object_form *form, double half, double coordinate);

// Unlike fmin and fmax these are no calls, which would take longer than the rest.
static inline double lesser(double a, double b)
{
    return a < b ? a : b;
}

static inline double greater(double a, double b)
{
    return a > b ? a : b;
}

#endif
