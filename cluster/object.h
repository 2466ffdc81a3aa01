// SPDX-License-Identifier: MIT
// One object: its form, where it is, how far it reaches, and whether it is sound.
#ifndef CLUSTER_OBJECT_H
#define CLUSTER_OBJECT_H

#include "cluster/extent.h"
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

// Returns bounds that contain all that the devices or the reference take for the object's, however
// a box is turned, and in 2D 0 along z.
extent extent_of(const object_form *form, const void *object);

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

#endif
