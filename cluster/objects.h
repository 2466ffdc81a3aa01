// SPDX-License-Identifier: MIT
// Objects with their global ids, as rows that travel between ranks, and where they are.
#ifndef CLUSTER_OBJECTS_H
#define CLUSTER_OBJECTS_H

#include "kernels/grid/skim.h"
#include "runtime/duet.h"

typedef struct object_rows object_rows;

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

// Summary of rows that lie deep inside of a box.
typedef struct skim {
    extent centres;
    double square; // the square of the greatest half extent along any axis, however the objects are
                   // turned
} skim;

extern const skim skim_none;

// Adds the rows from `first` on whose centre lies inside of that, and returns the first row for
// which a glance does not decide, or which is not sound; `end` if there is none.
uint32_t object_rows_skim(const object_rows *rows, const object_form *form, uint32_t first,
                          uint32_t end, const extent *inside, skim *s);
// The same by a device: the box as it takes it, and a block of its answer.
void skim_box(const extent *inside, float lower[3], float upper[3]);
void skim_add_block(skim *s, const skim_block *block);
// Returns no less than the width of any of them.
double skim_widest(const skim *s, const object_form *form);

// The point that decides which domain an object belongs to.
void object_centre(const object_form *form, const void *object, double centre[3]);
bool object_is_sound(const object_form *form, const void *object);

// Objects in one array and their ids in another.
struct object_rows {
    uint64_t *ids;
    unsigned char *objects; // [n][form.bytes]
    uint32_t n;
    uint64_t capacity; // rows for which there is memory
};

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
