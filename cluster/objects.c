// SPDX-License-Identifier: MIT
#include "cluster/objects.h"

#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// A world holds as many.
#define MOST_OBJECTS 4294967294u

// Beyond what the devices round: parts of a box's size, which they widen by less than 2^-17;
// of its coordinates as floats; and of an origin cell, whose corners lie up to 2^30 edges from 0.
#define SIZE_SLACK 0x1p-12
#define FLOAT_SLACK 0x1p-20
#define ORIGIN_SLACK 0x1p-20

// ---------------------------------------------------------------- one object

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
    if (form->shape == DUET_SHAPE_BOUNDS)
        return DUET_OBJECT_BOUNDS;
    return form->origin > 0.0f ? DUET_OBJECT_LARGE_POSES : DUET_OBJECT_POSES;
}

const reach reach_none = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

// Unlike fmin and fmax these are no calls, which would take longer than the rest.
static inline double lesser(double a, double b)
{
    return a < b ? a : b;
}

static inline double greater(double a, double b)
{
    return a > b ? a : b;
}

double reach_widest(const reach *r)
{
    double widest = greater(r->upper[0] - r->lower[0], r->upper[1] - r->lower[1]);
    return greater(widest, r->upper[2] - r->lower[2]);
}

static void widen(reach *r, const double slack[3], uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k) {
        r->lower[k] -= slack[k];
        r->upper[k] += slack[k];
    }
}

// Around the bounding sphere where boxes are rotated: which rank needs an object is decided
// faster than its bounds are found.
static reach reach_of_pose(const object_form *form, const void *object)
{
    const duet_pose *p = origin_pose(object, form->origin, 0);
    double corner[3], half[3], slack[3], squares = 0;
    reach r = {{0}, {0}};
    origin_corner(corner, object, form->origin, 0);
    for (uint32_t k = 0; k < form->dims; ++k) {
        half[k] = (double)p->half_extents[k];
        squares += half[k] * half[k];
    }
    double radius = sqrt(squares);
    for (uint32_t k = 0; k < form->dims; ++k) {
        double centre = (double)p->centre[k], to = form->rotated ? radius : half[k];
        r.lower[k] = corner[k] + (centre - to);
        r.upper[k] = corner[k] + (centre + to);
        slack[k] =
            SIZE_SLACK * radius + FLOAT_SLACK * fabs(centre) + ORIGIN_SLACK * (double)form->origin;
    }
    widen(&r, slack, form->dims);
    return r;
}

reach reach_of(const object_form *form, const void *object)
{
    if (form->shape == DUET_SHAPE_POSES)
        return reach_of_pose(form, object);
    const duet_bounds *b = object;
    reach r = {{0}, {0}};
    for (uint32_t k = 0; k < form->dims; ++k) {
        r.lower[k] = (double)b->lower[k];
        r.upper[k] = (double)b->upper[k];
    }
    return r;
}

void reach_add(reach *to, const reach *other)
{
    for (int k = 0; k < 3; ++k) {
        to->lower[k] = lesser(to->lower[k], other->lower[k]);
        to->upper[k] = greater(to->upper[k], other->upper[k]);
    }
}

bool reaches_meet(const reach *a, const reach *b)
{
    for (int k = 0; k < 3; ++k)
        if (a->lower[k] > b->upper[k] || b->lower[k] > a->upper[k])
            return false;
    return true;
}

void object_centre(const object_form *form, const void *object, double centre[3])
{
    double corner[3] = {0, 0, 0};
    const duet_bounds *b = object;
    const duet_pose *p = NULL;
    if (form->shape == DUET_SHAPE_POSES) {
        p = origin_pose(object, form->origin, 0);
        origin_corner(corner, object, form->origin, 0);
    }
    centre[2] = 0;
    for (uint32_t k = 0; k < form->dims; ++k)
        centre[k] = p ? corner[k] + (double)p->centre[k]
                      : 0.5 * ((double)b->lower[k] + (double)b->upper[k]);
}

bool object_is_sound(const object_form *form, const void *object)
{
    if (form->shape == DUET_SHAPE_POSES)
        return narrow_is_box(origin_pose(object, form->origin, 0), form->dims);
    const duet_bounds *b = object;
    for (uint32_t k = 0; k < form->dims; ++k)
        if (!isfinite(b->lower[k]) || !isfinite(b->upper[k]) || b->lower[k] > b->upper[k])
            return false;
    return true;
}

// ---------------------------------------------------------------- rows

bool object_rows_begin(object_rows *rows, const object_form *form, uint64_t n, duet_error *err)
{
    *rows = (object_rows){0};
    if (n > MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects on one rank; a rank holds at most %u", n,
                         MOST_OBJECTS);
    rows->n = (uint32_t)n;
    rows->ids = malloc((n + 1) * sizeof *rows->ids);
    rows->objects = malloc((n + 1) * form->bytes);
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

uint32_t object_message_bytes(const object_form *form)
{
    return (uint32_t)sizeof(uint64_t) + form->bytes;
}

void object_write_message(const object_form *form, void *message, uint64_t id, const void *object)
{
    memcpy(message, &id, sizeof id);
    memcpy((unsigned char *)message + sizeof id, object, form->bytes);
}

static int by_id(const void *left, const void *right)
{
    const arrival *p = left, *q = right;
    return (p->id > q->id) - (p->id < q->id);
}

arrival *arrivals_sort(const object_form *form, const void *messages, uint64_t n, duet_error *err)
{
    const unsigned char *message = messages;
    arrival *arrivals = malloc((n + 1) * sizeof *arrivals);
    if (!arrivals) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects that arrive: no memory", n);
        return NULL;
    }
    for (uint64_t i = 0; i < n; ++i, message += object_message_bytes(form)) {
        memcpy(&arrivals[i].id, message, sizeof arrivals[i].id);
        arrivals[i].object = message + sizeof arrivals[i].id;
        arrivals[i].place = i;
    }
    qsort(arrivals, n, sizeof *arrivals, by_id);
    return arrivals;
}

bool object_rows_merge(object_rows *to, const object_form *form, const object_rows *homes,
                       const bool *stays, const arrival *arrivals, uint64_t n, uint64_t *sources,
                       duet_error *err)
{
    uint64_t next = 0;
    to->n = 0;
    for (uint32_t i = 0; i < homes->n || next < n;) {
        if (i < homes->n && stays && !stays[i]) {
            ++i;
            continue;
        }
        bool home_is_next = next == n || (i < homes->n && homes->ids[i] < arrivals[next].id);
        const void *object = home_is_next ? object_row(homes, form, i) : arrivals[next].object;
        uint32_t at = to->n++;
        if (sources)
            sources[at] = home_is_next ? i : homes->n + arrivals[next].place;
        to->ids[at] = home_is_next ? homes->ids[i++] : arrivals[next++].id;
        memcpy(object_row(to, form, at), object, form->bytes);
        if (at > 0 && to->ids[at] == to->ids[at - 1])
            return error_set(err, DUET_STATUS_BAD_ARGUMENT, "object %" PRIu64 " is there twice",
                             to->ids[at]);
    }
    return true;
}
