// SPDX-License-Identifier: MIT
// Objects: the form that all of a world have, where one is, how far it reaches, and whether it is
// sound; and with their global ids, as rows that travel between ranks.
#ifndef CLUSTER_OBJECTS_H
#define CLUSTER_OBJECTS_H

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

// Objects in one array and their ids in another.
typedef struct object_rows {
    uint64_t *ids;
    unsigned char *objects; // [n][form.bytes]
    uint32_t n;
    uint64_t capacity; // rows for which there is memory
} object_rows;

// Makes space for n rows.
bool object_rows_begin(object_rows *rows, const object_form *form, uint64_t n, duet_error *err);
void object_rows_end(object_rows *rows);
// NULL of rows that were never reserved.
static inline void *object_row(const object_rows *rows, const object_form *form, uint32_t i)
{
    return rows->objects ? rows->objects + (size_t)i * form->bytes : NULL;
}

void object_row_centre(const object_rows *rows, const object_form *form, uint32_t i,
                       double centre[3]);

// The bytes of a message's row: an id and its object.
uint32_t object_message_bytes(const object_form *form);
void object_write_message(const object_form *form, void *message, uint64_t id, const void *object);

// n rows become *rows, by ascending id; false with BAD_ARGUMENT if an id is there twice.
bool object_rows_copy(object_rows *rows, const object_form *form, const uint64_t *ids,
                      const void *objects, uint32_t n, duet_error *err);

// Turns poses or spheres into rounded boxes, and *form into the form of these boxes.
bool object_rows_round(object_rows *rows, object_form *form, duet_error *err);

// The n rows of that list become the rows of `to` from `at` on, for which there is space.
void object_rows_gather(object_rows *to, const object_form *form, uint64_t at,
                        const object_rows *from, const uint32_t *list, uint64_t n);

// Adds n rows, for which there is space.
void object_rows_append(object_rows *to, const object_form *form, const uint64_t *ids,
                        const void *objects, uint32_t n);

#endif
