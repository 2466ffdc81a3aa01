// SPDX-License-Identifier: MIT
#include "cluster/objects.h"

#include "base/compare.h"
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- one object

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

// ---------------------------------------------------------------- rows

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
    return no_memory(err, "%" PRIu64 " objects", n);
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
        return no_memory(err, "%u objects", rows->n);
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
    bool ok = sorted || no_memory(err, "%u objects", n);
    ok = ok && object_rows_begin(rows, form, n, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
        if (i > 0 && sorted[i].id == sorted[i - 1].id)
            ok = bad_argument(err, "object %" PRIu64 " is there twice", sorted[i].id);
        rows->ids[i] = sorted[i].id;
        memcpy(object_row(rows, form, i),
               (const char *)objects + (size_t)sorted[i].row * form->bytes, form->bytes);
    }
    free(sorted);
    return ok;
}
