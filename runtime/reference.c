// SPDX-License-Identifier: MIT
// All pairs of a scene on one core.
//
// Objects are put into levels by size, a level's edge being the power of two
// at or above its objects' extents, and each level into columns along x of
// that edge. An object then meets its equals and all larger ones: of each
// level three by three columns, in each a run along x.
#include "runtime/reference.h"

#include "runtime/base/error.h"
#include "runtime/narrow.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

enum { EACH_WITH_EACH_LIMIT = 2000, MAX_LEVELS = 512 };

typedef struct bounds {
    double lower[3], upper[3];
} bounds;

typedef struct entry {
    bounds box;
    double z, y; // the column of its centre, in edges of its level
    double edge; // of its level
    uint32_t id;
} entry;

typedef struct finder {
    const reference_objects *objects;
    entry *entries; // where columns are used: by level, column and lower x
    reference_found *found;
    uint64_t room;
    duet_error *err;
} finder;

// ------------------------------------------------------------ bounds

// Half the extent of a box along x, y and z: |R| h. The rounding of the sums,
// some 20 parts in 2^53, is far below the part in 2^40 that is added.
static void reach_of_pose(const duet_pose *pose, double reach[3])
{
    double x = pose->rotation[0], y = pose->rotation[1], z = pose->rotation[2];
    double w = pose->rotation[3];
    double norm = x * x + y * y + z * z + w * w;
    const double m[3][3] = {
        {w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z},
    };
    const float *h = pose->half;
    double slack = 0x1p-40 * ((double)h[0] + h[1] + h[2]);
    for (int i = 0; i < 3; ++i) {
        double sum = fabs(m[i][0]) * h[0] + fabs(m[i][1]) * h[1] + fabs(m[i][2]) * h[2];
        reach[i] = sum / norm + slack;
    }
}

static bounds bounds_of_pose(const duet_pose *pose, uint32_t dims)
{
    duet_pose flat = narrow_flat(pose, dims);
    double reach[3];
    bounds b;
    reach_of_pose(&flat, reach);
    for (int i = 0; i < 3; ++i) {
        b.lower[i] = nextafter(flat.centre[i] - reach[i], -INFINITY);
        b.upper[i] = nextafter(flat.centre[i] + reach[i], INFINITY);
    }
    return b;
}

static bounds bounds_of(const reference_objects *objects, uint32_t id)
{
    if (objects->shape == DUET_SHAPE_POSES)
        return bounds_of_pose(&objects->poses[id], objects->dims);
    bounds b = {{0}, {0}};
    for (uint32_t i = 0; i < objects->dims; ++i) {
        b.lower[i] = objects->bounds[id].lower[i];
        b.upper[i] = objects->bounds[id].upper[i];
    }
    return b;
}

static bool overlap(const bounds *a, const bounds *b)
{
    for (int i = 0; i < 3; ++i)
        if (a->upper[i] < b->lower[i] || b->upper[i] < a->lower[i])
            return false;
    return true;
}

// ------------------------------------------------------------ pairs

static bool add_pair(finder *f, uint32_t a, uint32_t b)
{
    if (f->found->n == f->room) {
        uint64_t room = f->room ? 2 * f->room : 1024;
        duet_pair *pairs = realloc(f->found->pairs, room * sizeof *pairs);
        if (!pairs)
            return error_set(f->err, DUET_NO_MEMORY, "reference: no memory for %" PRIu64 " pairs",
                             room);
        f->found->pairs = pairs;
        f->room = room;
    }
    f->found->pairs[f->found->n++] = (duet_pair){a < b ? a : b, a < b ? b : a};
    return true;
}

static bool collide(const reference_objects *o, uint32_t a, uint32_t b)
{
    return o->shape == DUET_SHAPE_POSES ? narrow_decide(&o->poses[a], &o->poses[b], o->dims)
                                        : narrow_bounds(&o->bounds[a], &o->bounds[b], o->dims);
}

static bool test_pair(finder *f, const entry *a, const entry *b)
{
    if (!overlap(&a->box, &b->box))
        return true;
    ++f->found->candidates;
    return !collide(f->objects, a->id, b->id) || add_pair(f, a->id, b->id);
}

static int compare_pairs(const void *left, const void *right)
{
    const duet_pair *p = left, *q = right;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

// ------------------------------------------------------------ each with each

static bool find_each_with_each(finder *f)
{
    for (uint32_t i = 0; i < f->objects->n; ++i)
        for (uint32_t j = i + 1; j < f->objects->n; ++j)
            if (!test_pair(f, &f->entries[i], &f->entries[j]))
                return false;
    return true;
}

// ------------------------------------------------------------ columns

// The column of a coordinate. An edge is a power of two, so that this is exact.
static double column_of(double at, double edge)
{
    return floor(at / edge);
}

// Above 2^53 a column's successor is the next number there is.
static double column_after(double column)
{
    return fmax(column + 1, nextafter(column, INFINITY));
}

static void enter_level(entry *e)
{
    const bounds *b = &e->box;
    double extent = 0x1p-160; // so that points have a level too
    for (int i = 0; i < 3; ++i)
        extent = fmax(extent, b->upper[i] - b->lower[i]);
    int power;
    frexp(extent, &power);
    e->edge = ldexp(1, power);
    e->y = column_of(0.5 * (b->lower[1] + b->upper[1]), e->edge);
    e->z = column_of(0.5 * (b->lower[2] + b->upper[2]), e->edge);
}

static int compare_numbers(double x, double y)
{
    return (x > y) - (x < y);
}

static int compare_columns(const entry *e, double z, double y)
{
    return e->z != z ? compare_numbers(e->z, z) : compare_numbers(e->y, y);
}

static int compare_entries(const void *left, const void *right)
{
    const entry *p = left, *q = right;
    if (p->edge != q->edge)
        return compare_numbers(p->edge, q->edge);
    int by_column = compare_columns(p, q->z, q->y);
    return by_column ? by_column : compare_numbers(p->box.lower[0], q->box.lower[0]);
}

// The first of the entries from..to at or behind (z, y, x).
static size_t find_entry(const entry *entries, size_t from, size_t to, double z, double y, double x)
{
    while (from < to) {
        size_t middle = from + (to - from) / 2;
        int order = compare_columns(&entries[middle], z, y);
        if (order < 0 || (order == 0 && entries[middle].box.lower[0] < x))
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

// Meets the entries from..to of one column that begin at most an edge before e.
static bool meet_column(finder *f, const entry *e, size_t from, size_t to, double z, double y)
{
    double edge = f->entries[from].edge;
    size_t at = find_entry(f->entries, from, to, z, y, e->box.lower[0] - edge);
    for (; at < to; ++at) {
        const entry *other = &f->entries[at];
        if (compare_columns(other, z, y) != 0 || other->box.lower[0] > e->box.upper[0])
            return true;
        if (!test_pair(f, e, other))
            return false;
    }
    return true;
}

// The entries from..to are of one level, at or above e's. Those that meet e
// have their centres at most half an edge outside its bounds, and rounding
// keeps that order.
static bool meet_level(finder *f, const entry *e, size_t from, size_t to)
{
    double edge = f->entries[from].edge;
    double last_z = column_of(e->box.upper[2] + edge / 2, edge);
    double last_y = column_of(e->box.upper[1] + edge / 2, edge);
    double z = column_of(e->box.lower[2] - edge / 2, edge);
    for (; z <= last_z; z = column_after(z)) {
        double y = column_of(e->box.lower[1] - edge / 2, edge);
        for (; y <= last_y; y = column_after(y))
            if (!meet_column(f, e, from, to, z, y))
                return false;
    }
    return true;
}

// Where each level's entries end.
static int mark_levels(const finder *f, size_t ends[MAX_LEVELS])
{
    int n = 0;
    for (size_t i = 1; i <= f->objects->n; ++i)
        if (i == f->objects->n || f->entries[i].edge != f->entries[i - 1].edge)
            ends[n++] = i;
    return n;
}

static bool meet_levels(finder *f, size_t self, const size_t *ends, int level, int n_levels)
{
    size_t from = self + 1;
    for (; level < n_levels; ++level) {
        if (from < ends[level] && !meet_level(f, &f->entries[self], from, ends[level]))
            return false;
        from = ends[level];
    }
    return true;
}

static bool find_by_columns(finder *f)
{
    size_t ends[MAX_LEVELS];
    size_t n = f->objects->n;
    for (size_t i = 0; i < n; ++i)
        enter_level(&f->entries[i]);
    qsort(f->entries, n, sizeof *f->entries, compare_entries);
    int n_levels = mark_levels(f, ends);
    int level = 0;
    for (size_t i = 0; i < n; ++i) {
        if (i == ends[level])
            ++level;
        if (!meet_levels(f, i, ends, level, n_levels))
            return false;
    }
    return true;
}

// ------------------------------------------------------------ the whole

static bool make_entries(finder *f)
{
    uint32_t n = f->objects->n;
    f->entries = calloc(n ? n : 1, sizeof *f->entries);
    if (!f->entries)
        return error_set(f->err, DUET_NO_MEMORY, "reference: no memory for %" PRIu32 " objects", n);
    for (uint32_t i = 0; i < n; ++i) {
        f->entries[i].id = i;
        f->entries[i].box = bounds_of(f->objects, i);
    }
    return true;
}

bool reference_find(const reference_objects *objects, reference_way way, reference_found *found,
                    duet_error *err)
{
    *found = (reference_found){0};
    finder f = {.objects = objects, .found = found, .err = err};
    bool ok = make_entries(&f);
    ok = ok && (way == REFERENCE_COLUMNS ? find_by_columns(&f) : find_each_with_each(&f));
    free(f.entries);
    if (!ok) {
        duet_free(found->pairs);
        *found = (reference_found){0};
        return false;
    }
    if (found->n > 0)
        qsort(found->pairs, found->n, sizeof *found->pairs, compare_pairs);
    return true;
}

bool duet_reference(const duet_scene *scene, duet_pair **pairs, uint64_t *n, duet_error *err)
{
    const duet_scene_info *info = duet_scene_describe(scene);
    reference_objects objects = {info->dims, info->shape, info->n, duet_scene_poses(scene),
                                 duet_scene_bounds(scene)};
    reference_way way =
        info->n <= EACH_WITH_EACH_LIMIT ? REFERENCE_EACH_WITH_EACH : REFERENCE_COLUMNS;
    reference_found found;
    if (!reference_find(&objects, way, &found, err))
        return false;
    *pairs = found.pairs;
    *n = found.n;
    return true;
}

void duet_free(void *memory)
{
    free(memory);
}
