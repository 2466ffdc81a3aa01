// SPDX-License-Identifier: MIT
#include "cluster/objects.h"

#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// Beyond what the devices round: parts of a box's size, which they widen by less than 2^-17;
// of its coordinates as floats, and what they add to 0; and of an origin cell, whose corners lie up
// to 2^30 edges from 0.
#define SIZE_SLACK 0x1p-12
#define FLOAT_SLACK 0x1p-20
#define LEAST_SLACK 0x1p-124
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
    return origin_row_kind(form->shape, form->origin);
}

// Rows begin with a centre, unless they are bounds.
static const float *centre_of(const void *object)
{
    return object;
}

// A pose, or the core of what has a radius. Spheres have none.
static const duet_pose *pose_of(const object_form *form, const void *object)
{
    return form->shape == DUET_SHAPE_SPHERES ? NULL : object;
}

static double radius_of(const object_form *form, const void *object)
{
    return form->shape == DUET_SHAPE_ROUNDED_BOXES
               ? (double)((const duet_rounded_box *)object)->radius
           : form->shape == DUET_SHAPE_SPHERES ? (double)((const duet_sphere *)object)->radius
                                               : 0;
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
    const duet_pose *p = pose_of(form, object);
    double corner[3], half[3], slack[3], squares = 0, radius = radius_of(form, object);
    reach r = {{0}, {0}};
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
        slack[k] = SIZE_SLACK * (around + radius) + FLOAT_SLACK * fabs(centre) +
                   ORIGIN_SLACK * (double)form->origin + LEAST_SLACK;
    }
    widen(&r, slack, form->dims);
    return r;
}

reach reach_of(const object_form *form, const void *object)
{
    if (form->shape != DUET_SHAPE_BOUNDS)
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

bool reach_holds(const reach *r, const double point[3], double width)
{
    double margin = 1.01 * width;
    for (int k = 0; k < 3; ++k)
        if (!(point[k] - margin > r->lower[k] && point[k] + margin < r->upper[k]))
            return false;
    return true;
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

// Of a reach around what has a radius, but for what is rounded.
static double half_width(const object_form *form, const void *object)
{
    const duet_pose *core = pose_of(form, object);
    double squares = 0;
    for (uint32_t k = 0; core && k < form->dims; ++k)
        squares += (double)core->half_extents[k] * (double)core->half_extents[k];
    return sqrt(squares) + radius_of(form, object);
}

// Sound in 3D, found without a branch for each number; a flat box may be sound where that says no.
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
    const duet_pose *p = pose_of(form, object);
    double radius = radius_of(form, object);
    return radius >= 0 && isfinite(radius) &&
           (p ? is_plainly_sound(p) || narrow_is_box(p, form->dims)
              : is_finite_point(centre_of(object), form->dims));
}

// ---------------------------------------------------------------- many at a glance

const skim skim_none = {{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}, 0};

// The nearest floats not below a number, and not above it.
static float above(float rounded, double number)
{
    return (double)rounded < number ? nextafterf(rounded, INFINITY) : rounded;
}

static float below(float rounded, double number)
{
    return (double)rounded > number ? nextafterf(rounded, -INFINITY) : rounded;
}

void skim_box(const reach *inside, float lower[3], float upper[3])
{
    for (int k = 0; k < 3; ++k) {
        lower[k] = above((float)inside->lower[k], inside->lower[k]);
        upper[k] = below((float)inside->upper[k], inside->upper[k]);
    }
}

// Of bounds a block has more than their centres; squares are short by less than 2^-21.
void skim_add_block(skim *s, const skim_block *block)
{
    for (int k = 0; k < 3; ++k) {
        s->centres.lower[k] = lesser(s->centres.lower[k], (double)block->lower[k]);
        s->centres.upper[k] = greater(s->centres.upper[k], (double)block->upper[k]);
    }
    s->square = greater(s->square, (double)block->square * (1 + 0x1p-20));
}

enum { SIDE_BY_SIDE = 4 }; // numbers that a compiler takes together

// A pose is ten numbers: its centre and a half extent, three half extents and one of the rotation,
// the rotation. Without a branch but the one that ends it, so that it takes little longer than
// reading the rows.
static uint32_t skim_poses(const duet_pose *poses, uint32_t dims, uint32_t first, uint32_t end,
                           const reach *inside, skim *to)
{
    float lower[SIDE_BY_SIDE], upper[SIDE_BY_SIDE], least[SIDE_BY_SIDE], most[SIDE_BY_SIDE];
    double square = to->square, in_3d = dims == 3;
    skim_box(inside, lower, upper);
    for (int k = 0; k < SIDE_BY_SIDE; ++k) {
        if ((uint32_t)k >= dims) {
            lower[k] = -INFINITY;
            upper[k] = INFINITY;
        }
        least[k] = INFINITY;
        most[k] = -INFINITY;
    }
    uint32_t i = first;
    for (; i < end; ++i) {
        float centre[SIDE_BY_SIDE], half[SIDE_BY_SIDE], turn[SIDE_BY_SIDE];
        memcpy(centre, poses[i].centre, sizeof centre);
        memcpy(half, poses[i].half_extents, sizeof half);
        memcpy(turn, poses[i].rotation, sizeof turn);
        int odd = 0;
        for (int k = 0; k < SIDE_BY_SIDE; ++k) {
            float zero = 0.0f * (centre[k] + half[k] + turn[k]);
            odd |= !(zero == 0.0f) | !(centre[k] > lower[k]) | !(centre[k] < upper[k]);
        }
        odd |= !(half[0] >= 0.0f) | !(half[1] >= 0.0f) | !(half[2] >= 0.0f);
        odd |= (turn[2] == 0.0f) & (turn[3] == 0.0f);
        if (odd)
            break;
        for (int k = 0; k < SIDE_BY_SIDE; ++k) {
            least[k] = centre[k] < least[k] ? centre[k] : least[k];
            most[k] = centre[k] > most[k] ? centre[k] : most[k];
        }
        double x = (double)half[0], y = (double)half[1], z = in_3d * (double)half[2];
        square = greater(x * x + y * y + z * z, square);
    }
    for (uint32_t k = 0; k < 3; ++k) {
        bool along = k < dims;
        to->centres.lower[k] = lesser(along ? (double)least[k] : 0, to->centres.lower[k]);
        to->centres.upper[k] = greater(along ? (double)most[k] : 0, to->centres.upper[k]);
    }
    to->square = square;
    return i;
}

// An object of that half width, or nothing and false where it does not lie inside.
static inline bool skim_add(skim *to, const reach *inside, const double at[3], double half)
{
    bool deep = true;
    for (int k = 0; k < 3; ++k)
        deep &= (at[k] > inside->lower[k]) & (at[k] < inside->upper[k]);
    if (!deep)
        return false;
    to->square = greater(half * half, to->square);
    for (int k = 0; k < 3; ++k) {
        to->centres.lower[k] = lesser(at[k], to->centres.lower[k]);
        to->centres.upper[k] = greater(at[k], to->centres.upper[k]);
    }
    return true;
}

static uint32_t skim_bounds(const object_rows *rows, uint32_t dims, uint32_t first, uint32_t end,
                            const reach *inside, skim *to)
{
    const object_form form = {
        .dims = dims, .shape = DUET_SHAPE_BOUNDS, .bytes = sizeof(duet_bounds)};
    for (; first < end; ++first) {
        const duet_bounds *b = object_row(rows, &form, first);
        double at[3], widest = 0;
        object_centre(&form, b, at);
        for (uint32_t k = 0; k < dims; ++k)
            widest = greater(widest, (double)b->upper[k] - (double)b->lower[k]);
        if (!object_is_sound(&form, b) || !skim_add(to, inside, at, 0.5 * widest))
            break;
    }
    return first;
}

static uint32_t skim_with_radii(const object_rows *rows, const object_form *form, uint32_t first,
                                uint32_t end, const reach *inside, skim *to)
{
    for (; first < end; ++first) {
        const void *object = object_row(rows, form, first);
        double at[3];
        object_centre(form, object, at);
        if (!object_is_sound(form, object) || !skim_add(to, inside, at, half_width(form, object)))
            break;
    }
    return first;
}

uint32_t object_rows_skim(const object_rows *rows, const object_form *form, uint32_t first,
                          uint32_t end, const reach *inside, skim *s)
{
    if (form->shape == DUET_SHAPE_BOUNDS)
        return skim_bounds(rows, form->dims, first, end, inside, s);
    if (form->shape != DUET_SHAPE_POSES)
        return skim_with_radii(rows, form, first, end, inside, s);
    if (form->origin > 0.0f)
        return first;
    return skim_poses((const duet_pose *)(const void *)rows->objects, form->dims, first, end,
                      inside, s);
}

double skim_widest(const skim *s, const object_form *form)
{
    double far = 0, half = sqrt(s->square), slack = 0;
    if (s->centres.lower[0] > s->centres.upper[0])
        return 0;
    for (int k = 0; k < 3; ++k)
        far = greater(far, greater(fabs(s->centres.lower[k]), fabs(s->centres.upper[k])));
    if (form->shape != DUET_SHAPE_BOUNDS)
        slack = SIZE_SLACK * half + FLOAT_SLACK * far + LEAST_SLACK;
    return 2 * (1 + 0x1p-20) * (half + slack);
}

// ---------------------------------------------------------------- rows

bool object_rows_reserve(object_rows *rows, const object_form *form, uint64_t n, duet_error *err)
{
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects on one rank; a rank holds at most %u", n,
                         DUET_MOST_OBJECTS);
    if (!rows->ids || n > rows->capacity) {
        object_rows_end(rows);
        rows->capacity = n + n / 16;
        rows->ids = malloc((rows->capacity + 1) * sizeof *rows->ids);
        rows->objects = malloc((rows->capacity + 1) * form->bytes);
    }
    if (!rows->ids || !rows->objects) {
        object_rows_end(rows);
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
    }
    rows->n = (uint32_t)n;
    return true;
}

bool object_rows_begin(object_rows *rows, const object_form *form, uint64_t n, duet_error *err)
{
    *rows = (object_rows){0};
    return object_rows_reserve(rows, form, n, err);
}

void object_rows_end(object_rows *rows)
{
    free(rows->ids);
    free(rows->objects);
    *rows = (object_rows){0};
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
    return form->shape == DUET_SHAPE_SPHERES ? rounded_of_sphere(object)
                                             : (duet_rounded_box){.pose = *pose_of(form, object)};
}

// Where they lie, from the last one on, for none becomes smaller.
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

static int by_id(const void *left, const void *right)
{
    const arrival *p = left, *q = right;
    return (p->id > q->id) - (p->id < q->id);
}

void arrivals_sort(arrival *arrivals, uint64_t n)
{
    qsort(arrivals, n, sizeof *arrivals, by_id);
}

arrival *arrivals_read(const object_form *form, const void *messages, uint64_t n, duet_error *err)
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
    }
    arrivals_sort(arrivals, n);
    return arrivals;
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

// False where the first of them has the id of the row before it.
static bool append(object_rows *to, const object_form *form, const uint64_t *ids,
                   const void *objects, uint32_t n, duet_error *err)
{
    uint32_t at = to->n;
    object_rows_append(to, form, ids, objects, n);
    return n == 0 || at == 0 || to->ids[at] != to->ids[at - 1] ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "object %" PRIu64 " is there twice",
                     to->ids[at]);
}

uint32_t object_rows_find(const object_rows *rows, uint32_t first, uint32_t end, uint64_t id)
{
    uint32_t width = 1; // it is near, where few come among many
    while (width < end - first && rows->ids[first + width] < id)
        width *= 2;
    uint32_t last = width < end - first ? first + width : end;
    while (first < last) {
        uint32_t middle = first + (last - first) / 2;
        if (rows->ids[middle] < id)
            first = middle + 1;
        else
            last = middle;
    }
    return first;
}

bool object_rows_merge(object_rows *to, const object_form *form, const object_rows *homes,
                       const uint32_t *leavers, uint64_t n_leavers, const arrival *arrivals,
                       uint64_t n, duet_error *err)
{
    uint64_t leaver = 0, next = 0;
    uint32_t i = 0;
    bool ok = true;
    to->n = 0;
    while (ok && (i < homes->n || next < n)) {
        uint32_t end = leaver < n_leavers ? leavers[leaver] : homes->n;
        uint32_t run = next < n ? object_rows_find(homes, i, end, arrivals[next].id) : end;
        ok = append(to, form, homes->ids ? homes->ids + i : NULL, object_row(homes, form, i),
                    run - i, err);
        i = run;
        if (i == end && leaver < n_leavers) {
            ++leaver;
            ++i;
        } else if (ok && next < n) {
            ok = append(to, form, &arrivals[next].id, arrivals[next].object, 1, err);
            ++next;
        }
    }
    return ok;
}

static bool do_ascend(const uint64_t *ids, uint32_t n)
{
    bool ascend = true;
    for (uint32_t i = 1; ascend && i < n; ++i)
        ascend = ids[i - 1] < ids[i];
    return ascend;
}

bool object_rows_copy(object_rows *rows, const object_form *form, const uint64_t *ids,
                      const void *objects, uint32_t n, duet_error *err)
{
    const object_rows none = {0};
    if (do_ascend(ids, n)) {
        bool begun = object_rows_begin(rows, form, n, err);
        rows->n = 0;
        if (begun)
            object_rows_append(rows, form, ids, objects, n);
        return begun;
    }
    arrival *arrivals = malloc(((size_t)n + 1) * sizeof *arrivals);
    bool ok = arrivals || error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
    for (uint32_t i = 0; ok && i < n; ++i)
        arrivals[i] = (arrival){ids[i], (const char *)objects + (size_t)i * form->bytes};
    if (ok)
        arrivals_sort(arrivals, n);
    ok = ok && object_rows_begin(rows, form, n, err);
    ok = ok && object_rows_merge(rows, form, &none, NULL, 0, arrivals, n, err);
    free(arrivals);
    return ok;
}
