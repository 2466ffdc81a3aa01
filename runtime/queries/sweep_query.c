// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/rounded_sweep.h"
#include "runtime/queries/sweep.h"
#include "runtime/queries/tree_query.h"

#include <math.h>
#include <string.h>

enum { COOKIE = 0x0d0e700e };

_Static_assert(sizeof(duet_sweep) == 14 * sizeof(float), "a sweep is a pose and four floats");
_Static_assert(sizeof(duet_bounds_sweep) == 10 * sizeof(float), "and so with bounds");
_Static_assert(sizeof(duet_large_sweep) == 18 * sizeof(float), "and so with a large pose");
_Static_assert(sizeof(duet_rounded_sweep) == 15 * sizeof(float), "with rounded boxes");
_Static_assert(sizeof(duet_sweep_hit) == 6 * sizeof(uint32_t), "a hit is six words");

duet_sweep_query_def duet_default_sweep_query_def(void)
{
    return (duet_sweep_query_def){.cookie = COOKIE};
}

static bool meets(const duet_tree *tree, const void *item, uint32_t *hit)
{
    return sweep_meets(item, (const duet_pose *)tree->objects + hit[1], tree->def.dims);
}

static bool meets_bounds(const duet_tree *tree, const void *item, uint32_t *hit)
{
    return sweep_meets_bounds(item, (const duet_bounds *)tree->objects + hit[1], tree->def.dims);
}

static void enter(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    const duet_pose *box = (const duet_pose *)tree->objects + h->id;
    h->t = sweep_enter(item, box, tree->def.dims, h->normal);
}

static void enter_bounds(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    const duet_bounds *box = (const duet_bounds *)tree->objects + h->id;
    h->t = sweep_enter_bounds(item, box, tree->def.dims, h->normal);
}

static duet_sweep near_sweep(const duet_large_sweep *large)
{
    duet_sweep sweep = {.box = large->box, .t_max = large->t_max};
    memcpy(sweep.direction, large->direction, sizeof sweep.direction);
    return sweep;
}

static bool meets_far(const duet_tree *tree, const void *item, uint32_t *hit)
{
    const duet_large_sweep *large = item;
    const duet_large_pose *box = (const duet_large_pose *)tree->objects + hit[1];
    const duet_sweep sweep = near_sweep(large);
    double shift[3];
    far_shift(shift, box, large->cell, tree->def.origin_edge);
    return sweep_meets_apart(&sweep, &box->pose, shift, tree->def.dims);
}

static void enter_far(const duet_tree *tree, const void *item, uint32_t *hit)
{
    const duet_large_sweep *large = item;
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    const duet_large_pose *box = (const duet_large_pose *)tree->objects + h->id;
    const duet_sweep sweep = near_sweep(large);
    double shift[3];
    far_shift(shift, box, large->cell, tree->def.origin_edge);
    h->t = sweep_enter_apart(&sweep, &box->pose, shift, tree->def.dims, h->normal);
}

// A grazing one is left open before float knows where it touches.
static bool meets_rounded(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    const duet_rounded_box *box = (const duet_rounded_box *)tree->objects + h->id;
    if (!rounded_sweep_meets(item, box, tree->def.dims))
        return false;
    h->t = fmaxf(h->t, rounded_sweep_enter(item, box, tree->def.dims, h->normal));
    return true;
}

static void enter_rounded(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    const duet_rounded_box *box = (const duet_rounded_box *)tree->objects + h->id;
    h->t = rounded_sweep_enter(item, box, tree->def.dims, h->normal);
}

static bool meets_ground(const tree_query *q, const void *item, uint32_t *hit)
{
    const duet_shape shape = q->tree->def.shape;
    const ground_probe probe = shape == DUET_SHAPE_BOUNDS  ? ground_probe_of_bounds(item)
                               : shape == DUET_SHAPE_POSES ? ground_probe_of_sweep(item)
                                                           : ground_probe_of_rounded_sweep(item);
    duet_sweep_hit *h = (duet_sweep_hit *)hit;
    ground_entry entry;
    if (!ground_shape_meet(&q->tree->ground, &probe, &entry))
        return false;
    h->t = fminf((float)entry.t, probe.t_max);
    if (entry.t > 0.0)
        ground_set_normal(&entry, h->normal);
    return true;
}

// Spheres are rounded boxes to the kernel.
static void copy_spheres(const duet_tree *tree, const void *items, uint64_t n, void *to)
{
    const duet_sphere_sweep *given = items;
    duet_rounded_sweep *sweeps = to;
    (void)tree;
    for (uint64_t i = 0; i < n; ++i) {
        sweeps[i] = (duet_rounded_sweep){.box = rounded_of_sphere(&given[i].sphere),
                                         .t_max = given[i].t_max};
        memcpy(sweeps[i].direction, given[i].direction, sizeof given[i].direction);
    }
}

#define SWEEPS(type_, wrong_, meets_, enter_)                                     \
    .item = "sweep", .items = "sweeps", .wrong = (wrong_), .kernel = "ray_query", \
    .item_words = QUERY_WORDS(type_), .item_cell = FAR_POSE_CELL, .hit_words = 6, \
    .meets = (meets_), .finish = (enter_), .finish_reads = true

#define WRONG_ROUNDED                                                                            \
    "no box, a radius below 0, a number that is none or above 2^100, a direction below 2^-100, " \
    "or a t_max below 0"

const query_kinds sweep_kinds = {
    [DUET_SHAPE_POSES] = {SWEEPS(duet_sweep,
                                 "no box, a number that is none or above 2^100, a direction below "
                                 "2^-100, or a t_max below 0",
                                 meets, enter),
                          .meets_ground = meets_ground},
    [DUET_SHAPE_BOUNDS] = {SWEEPS(duet_bounds_sweep,
                                  "no bounds, a number that is none or above 2^100, a direction "
                                  "below 2^-100, or a t_max below 0",
                                  meets_bounds, enter_bounds),
                           .meets_ground = meets_ground},
    [DUET_SHAPE_ROUNDED_BOXES] = {SWEEPS(duet_rounded_sweep, WRONG_ROUNDED, meets_rounded,
                                         enter_rounded),
                                  .meets_ground = meets_ground},
    [DUET_SHAPE_SPHERES] = {SWEEPS(duet_rounded_sweep, WRONG_ROUNDED, meets_rounded, enter_rounded),
                            .copy = copy_spheres, .meets_ground = meets_ground},
    [DUET_SHAPES] = {SWEEPS(duet_large_sweep,
                            "no box, beyond 2^30 origin cells, a number that is none or above "
                            "2^100, a direction below 2^-100, or a t_max below 0",
                            meets_far, enter_far)},
};

duet_sweep_query *duet_sweep_query_create(const duet_sweep_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_sweep_query_def", err))
        return NULL;
    const any_query_def any = {.name = {.item = QUERY_SWEEPS, .wants = def->wants},
                               .filter = def->filter};
    return (duet_sweep_query *)tree_query_create(def->tree, sweep_kinds, &any, err);
}

void duet_sweep_query_destroy(duet_sweep_query *query)
{
    any_query_destroy((tree_query *)query);
}

bool duet_sweep_query_run(duet_sweep_query *query, duet_object_kind kind, const void *sweeps,
                          uint64_t n, duet_sweep_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    query_result found;
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err) ||
        !tree_takes(((tree_query *)query)->tree, kind, err) ||
        !any_query_run((tree_query *)query, sweeps, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_sweep_query_result, duet_sweep_hit, found);
    return true;
}
