// SPDX-License-Identifier: MIT
// All pairs of a scene on one core.
//
// Objects are put into classes by size, a class's edge being the power of two
// at or above its objects' extents, and each class into columns along x of
// that edge. An object then meets its equals and all larger ones: of each
// class three by three columns, in each a run along x.
#include "runtime/scene/reference.h"

#include "base/budget.h"
#include "base/compare.h"
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/narrowphase/sat_frame.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

// Tests between two looks at the budget: some milliseconds.
enum {
    EACH_WITH_EACH_LIMIT = 2000,
    MAX_CLASSES = 512,
    TESTS_AT_ONCE = 1 << 14,
    OBJECTS_AT_ONCE = 1 << 10
};

typedef struct bounds {
    double lower[3], upper[3];
} bounds;

typedef struct entry {
    bounds box;
    double z, y; // the column of its centre, in edges of its class
    double edge; // in its class
    uint32_t id;
} entry;

typedef struct finder {
    const reference_objects *objects;
    entry *entries; // if columns are used: by class, column and lower x
    reference_found *found;
    uint64_t capacity;
    uint32_t tests; // since the last look at the budget
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
    const float *h = pose->half_extents;
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

static bounds bounds_of_corners(const duet_bounds *corners, uint32_t dims)
{
    bounds b = {{0}, {0}};
    for (uint32_t i = 0; i < dims; ++i) {
        b.lower[i] = corners->lower[i];
        b.upper[i] = corners->upper[i];
    }
    return b;
}

static bool has_radii(const reference_objects *o)
{
    return o->shape == DUET_SHAPE_ROUNDED_BOXES || o->shape == DUET_SHAPE_SPHERES;
}

static duet_rounded_box rounded_box_of(const reference_objects *o, uint32_t id)
{
    return o->shape == DUET_SHAPE_SPHERES ? rounded_of_sphere(&o->spheres[id])
                                          : o->rounded_boxes[id];
}

static bounds bounds_of_rounded(const reference_objects *o, uint32_t id)
{
    duet_rounded_box box = rounded_box_of(o, id);
    if (o->level != DUET_LEVEL_CERTIFIED) {
        bool turned = o->rotated && o->shape != DUET_SHAPE_SPHERES;
        duet_bounds in_float = sat_rounded_bounds(&box, o->dims, turned);
        return bounds_of_corners(&in_float, o->dims);
    }
    bounds b = bounds_of_pose(&box.pose, o->dims);
    for (uint32_t i = 0; i < o->dims; ++i) {
        b.lower[i] = nextafter(b.lower[i] - box.radius, -INFINITY);
        b.upper[i] = nextafter(b.upper[i] + box.radius, INFINITY);
    }
    return b;
}

// From the corner of its origin cell to 0, and not smaller.
static bounds move_by(bounds b, const double corner[3])
{
    for (int i = 0; i < 3; ++i) {
        b.lower[i] = nextafter(b.lower[i] + corner[i], -INFINITY);
        b.upper[i] = nextafter(b.upper[i] + corner[i], INFINITY);
    }
    return b;
}

static bounds bounds_of(const reference_objects *objects, uint32_t id)
{
    uint32_t dims = objects->dims;
    if (objects->shape == DUET_SHAPE_BOUNDS)
        return bounds_of_corners(&objects->bounds[id], dims);
    if (has_radii(objects))
        return bounds_of_rounded(objects, id);
    const duet_pose *pose = origin_pose(objects->poses, objects->origin, id);
    duet_bounds in_float = sat_bounds(pose, dims, objects->rotated);
    bounds b = objects->level == DUET_LEVEL_CERTIFIED ? bounds_of_pose(pose, dims)
                                                      : bounds_of_corners(&in_float, dims);
    if (objects->origin == 0)
        return b;
    double corner[3];
    origin_corner(corner, objects->poses, objects->origin, id);
    corner[2] = dims == 3 ? corner[2] : 0;
    return move_by(b, corner);
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
    if (f->found->n == f->capacity) {
        uint64_t capacity = f->capacity ? 2 * f->capacity : 1024;
        if (!budget_space(capacity * sizeof *f->found->pairs, f->err))
            return false;
        duet_pair *pairs = realloc(f->found->pairs, capacity * sizeof *pairs);
        if (!pairs)
            return no_memory(f->err, "the reference's %" PRIu64 " pairs", capacity);
        f->found->pairs = pairs;
        f->capacity = capacity;
    }
    f->found->pairs[f->found->n++] = (duet_pair){a, b};
    return true;
}

static bool collide(const reference_objects *o, uint32_t a, uint32_t b)
{
    if (o->shape == DUET_SHAPE_BOUNDS)
        return narrow_bounds(&o->bounds[a], &o->bounds[b], o->dims);
    if (has_radii(o)) {
        bool turned = o->rotated && o->shape != DUET_SHAPE_SPHERES;
        duet_rounded_box box_a = rounded_box_of(o, a), box_b = rounded_box_of(o, b);
        return o->level == DUET_LEVEL_CERTIFIED
                   ? rounded_decide(&box_a, &box_b, o->dims)
                   : level_collide_rounded(o->level, &box_a, &box_b, o->dims, turned);
    }
    const duet_pose *pose_a = origin_pose(o->poses, o->origin, a);
    const duet_pose *pose_b = origin_pose(o->poses, o->origin, b);
    double shift[3];
    origin_shift(shift, o->poses, o->origin, a, b);
    if (o->level == DUET_LEVEL_CERTIFIED)
        return narrow_decide_apart(pose_a, pose_b, shift, o->dims);
    return level_collide(o->level, pose_a, pose_b, shift, o->dims, o->rotated);
}

static bool test_pair(finder *f, const entry *one, const entry *other)
{
    if (++f->tests == TESTS_AT_ONCE) {
        f->tests = 0;
        if (!budget_check(f->err))
            return false;
    }
    if (!overlap(&one->box, &other->box))
        return true;
    ++f->found->candidates;
    uint32_t a = one->id < other->id ? one->id : other->id;
    uint32_t b = one->id < other->id ? other->id : one->id;
    return !collide(f->objects, a, b) || add_pair(f, a, b);
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

static void enter_class(entry *e)
{
    const bounds *b = &e->box;
    double extent = 0x1p-160; // so that points have a class too
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

// The entries from..to are of one class, at or above e's. Objects that meet e have their centres at
// most half an edge outside its bounds, and rounding keeps that order.
static bool meet_class(finder *f, const entry *e, size_t from, size_t to)
{
    double edge = f->entries[from].edge;
    double last_z = column_of(e->box.upper[2] + edge / 2, edge);
    double last_y = column_of(e->box.upper[1] + edge / 2, edge);
    double z = column_of(e->box.lower[2] - edge / 2, edge);
    while (z <= last_z) {
        double y = column_of(e->box.lower[1] - edge / 2, edge);
        while (y <= last_y) {
            if (!meet_column(f, e, from, to, z, y))
                return false;
            y = column_after(y);
        }
        z = column_after(z);
    }
    return true;
}

// Finds the end of each class's entries.
static int mark_classes(const finder *f, size_t ends[MAX_CLASSES])
{
    int n = 0;
    for (size_t i = 1; i <= f->objects->n; ++i)
        if (i == f->objects->n || f->entries[i].edge != f->entries[i - 1].edge)
            ends[n++] = i;
    return n;
}

static bool meet_classes(finder *f, size_t self, const size_t *ends, int class, int n_classes)
{
    size_t from = self + 1;
    for (; class < n_classes; ++class) {
        if (from < ends[class] && !meet_class(f, &f->entries[self], from, ends[class]))
            return false;
        from = ends[class];
    }
    return true;
}

static bool find_by_columns(finder *f)
{
    size_t ends[MAX_CLASSES];
    size_t n = f->objects->n;
    for (size_t i = 0; i < n; ++i)
        enter_class(&f->entries[i]);
    qsort(f->entries, n, sizeof *f->entries, compare_entries);
    int n_classes = mark_classes(f, ends);
    int class = 0;
    for (size_t i = 0; i < n; ++i) {
        if (i % OBJECTS_AT_ONCE == 0)
            budget_tell(i, n);
        if (i == ends[class])
            ++class;
        if (!meet_classes(f, i, ends, class, n_classes))
            return false;
    }
    return true;
}

// ------------------------------------------------------------ the whole

static bool make_entries(finder *f)
{
    uint32_t n = f->objects->n;
    if (!budget_space(n * sizeof *f->entries, f->err))
        return false;
    f->entries = calloc(n ? n : 1, sizeof *f->entries);
    if (!f->entries)
        return no_memory(f->err, "the reference's %" PRIu32 " objects", n);
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
        qsort(found->pairs, found->n, sizeof *found->pairs, compare_uint32_pair);
    return true;
}

bool duet_reference(const duet_scene *scene, duet_level level, duet_pair **pairs, uint64_t *n,
                    duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(scene, __func__, "scene", err) ||
        !error_given(pairs, __func__, "pairs", err) || !error_given(n, __func__, "n", err))
        return false;
    if (!duet_level_get_info(level))
        return bad_argument(err, "level is %d; expected a duet_level", (int)level);
    const duet_scene_info *info = duet_scene_get_info(scene);
    reference_objects objects = {
        .dims = info->dims,
        .shape = info->shape,
        .n = info->n,
        .poses = duet_scene_get_objects(scene, info->origin_edge > 0 ? DUET_OBJECT_LARGE_POSES
                                                                     : DUET_OBJECT_POSES),
        .bounds = duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS),
        .rounded_boxes = duet_scene_get_objects(scene, DUET_OBJECT_ROUNDED_BOXES),
        .spheres = duet_scene_get_objects(scene, DUET_OBJECT_SPHERES),
        .level = level,
        .rotated = info->rotated,
        .origin = info->origin_edge,
    };
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
