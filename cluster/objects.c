// SPDX-License-Identifier: MIT
#include "cluster/objects.h"

#include "base/compare.h"
#include "base/error.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

bool object_rows_begin(object_rows *rows, const object_form *form, uint64_t n, duet_error *err)
{
    *rows = (object_rows){0};
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects on one rank; a rank holds at most %u", n,
                         DUET_MOST_OBJECTS);
    rows->n = (uint32_t)n;
    rows->capacity = n + n / 16;
    rows->ids = malloc((rows->capacity + 1) * sizeof *rows->ids);
    rows->objects = malloc((rows->capacity + 1) * form->bytes);
    if (rows->ids && rows->objects)
        return true;
    object_rows_end(rows);
    return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
}

void object_rows_end(object_rows *rows)
{
    free(rows->ids);
    free(rows->objects);
    *rows = (object_rows){0};
}

void object_row_centre(const object_rows *rows, const object_form *form, uint32_t i,
                       double centre[3])
{
    object_centre(form, object_row(rows, form, i), centre);
}

enum { ROWS_AHEAD = 8 }; // that are asked for; they lie anywhere

void object_rows_gather(object_rows *to, const object_form *form, uint64_t at,
                        const object_rows *from, const uint32_t *list, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i, ++at) {
        if (i + ROWS_AHEAD < n)
            __builtin_prefetch(object_row(from, form, list[i + ROWS_AHEAD]));
        to->ids[at] = from->ids[list[i]];
        memcpy(object_row(to, form, (uint32_t)at), object_row(from, form, list[i]), form->bytes);
    }
}

static duet_rounded_box rounded_box_of(const object_form *form, const void *object)
{
    return form->shape == DUET_SHAPE_SPHERES
               ? rounded_of_sphere(object)
               : (duet_rounded_box){.pose = *object_pose(form, object)};
}

// In place, and from the last one on, because none becomes smaller.
bool object_rows_round(object_rows *rows, object_form *form, duet_error *err)
{
    if (form->shape == DUET_SHAPE_ROUNDED_BOXES)
        return true;
    size_t bytes = origin_row_bytes(DUET_SHAPE_ROUNDED_BOXES, 0);
    unsigned char *objects = realloc(rows->objects, (rows->capacity + 1) * bytes);
    if (!objects)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", rows->n);
    rows->objects = objects;
    for (uint32_t i = rows->n; i-- > 0;) {
        duet_rounded_box box = rounded_box_of(form, object_row(rows, form, i));
        memcpy(objects + i * bytes, &box, bytes);
    }
    form->shape = DUET_SHAPE_ROUNDED_BOXES;
    form->bytes = (uint32_t)bytes;
    return true;
}

uint32_t object_message_bytes(const object_form *form)
{
    return (uint32_t)sizeof(uint64_t) + form->bytes;
}

void object_write_message(const object_form *form, void *message, uint64_t id, const void *object)
{
    memcpy(message, &id, sizeof id);
    memcpy((unsigned char *)message + sizeof id, object, form->bytes);
}

void object_rows_append(object_rows *to, const object_form *form, const uint64_t *ids,
                        const void *objects, uint32_t n)
{
    if (n == 0)
        return;
    memcpy(to->ids + to->n, ids, (size_t)n * sizeof *ids);
    memcpy(object_row(to, form, to->n), objects, (size_t)n * form->bytes);
    to->n += n;
}

// An id and the row that has it.
typedef struct id_row {
    uint64_t id;
    uint32_t row;
} id_row;

static int by_id(const void *left, const void *right)
{
    return compare_uint64(&((const id_row *)left)->id, &((const id_row *)right)->id);
}

static id_row *sort_ids(const uint64_t *ids, uint32_t n)
{
    id_row *sorted = malloc(((size_t)n + 1) * sizeof *sorted);
    bool ascend = true;
    for (uint32_t i = 0; sorted && i < n; ++i) {
        sorted[i] = (id_row){ids[i], i};
        ascend = ascend && (i == 0 || ids[i - 1] < ids[i]);
    }
    if (sorted && !ascend)
        qsort(sorted, n, sizeof *sorted, by_id);
    return sorted;
}

bool object_rows_copy(object_rows *rows, const object_form *form, const uint64_t *ids,
                      const void *objects, uint32_t n, duet_error *err)
{
    id_row *sorted = sort_ids(ids, n);
    bool ok = sorted || error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
    ok = ok && object_rows_begin(rows, form, n, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
        if (i > 0 && sorted[i].id == sorted[i - 1].id)
            ok = error_set(err, DUET_STATUS_BAD_ARGUMENT, "object %" PRIu64 " is there twice",
                           sorted[i].id);
        rows->ids[i] = sorted[i].id;
        memcpy(object_row(rows, form, i),
               (const char *)objects + (size_t)sorted[i].row * form->bytes, form->bytes);
    }
    free(sorted);
    return ok;
}
