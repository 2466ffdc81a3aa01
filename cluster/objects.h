// SPDX-License-Identifier: MIT
// Objects with their global ids, as rows that travel between ranks.
#ifndef CLUSTER_OBJECTS_H
#define CLUSTER_OBJECTS_H

#include "cluster/object.h"

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
