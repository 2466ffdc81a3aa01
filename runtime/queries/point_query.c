// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/tree_query.h"

#include <math.h>
#include <string.h>

enum { COOKIE = 0x0d0e700d };

_Static_assert(sizeof(duet_point) == 3 * sizeof(float), "a point is three floats");
_Static_assert(sizeof(duet_large_point) == 6 * sizeof(float), "and with its cell six words");
_Static_assert(sizeof(duet_point_hit) == 3 * sizeof(uint32_t), "a hit is three words");

duet_point_query_def duet_default_point_query_def(void)
{
    return (duet_point_query_def){.cookie = COOKIE};
}

// A ray that stays where it begins.
static bool meets(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_ray ray = {.t_max = 0};
    memcpy(ray.origin, item, sizeof ray.origin);
    if (tree->def.origin_edge > 0.0f) {
        const duet_large_pose *box = (const duet_large_pose *)tree->objects + hit[1];
        double shift[3];
        far_shift(shift, box, ((const duet_large_point *)item)->cell, tree->def.origin_edge);
        return ray_meets_apart(&ray, &box->pose, shift, tree->def.dims);
    }
    if (tree->def.shape == DUET_SHAPE_POSES)
        return ray_meets(&ray, (const duet_pose *)tree->objects + hit[1], tree->def.dims);
    return ray_meets_rounded(&ray, (const duet_rounded_box *)tree->objects + hit[1], tree->def.dims,
                             &ray.t_max);
}

static void take_root(const duet_tree *tree, const void *item, uint32_t *hit)
{
    (void)tree, (void)item;
    duet_point_hit *found = (duet_point_hit *)hit;
    found->distance = sqrtf(found->distance);
}

static bool meets_ground(const tree_query *q, const void *item, uint32_t *hit)
{
    const duet_point *point = item;
    if (q->wants != QUERY_NEAREST)
        return ground_shape_contain(&q->tree->ground, point->at);
    ((duet_point_hit *)hit)->distance = (float)ground_shape_distance(&q->tree->ground, point->at);
    return true;
}

#define POINTS(type_)                                                                           \
    {                                                                                           \
        .item = "point", .items = "points", .kernel = "point_query",                            \
        .wrong = "not a number, above 2^100, or beyond 2^30 origin cells",                      \
        .item_words = QUERY_WORDS(type_), .item_cell = QUERY_WORDS(duet_point), .hit_words = 3, \
        .meets = meets, .finish = take_root, .meets_ground = meets_ground                       \
    }

const query_kinds point_kinds = {POINTS(duet_point), POINTS(duet_point), POINTS(duet_point),
                                 POINTS(duet_point), POINTS(duet_large_point)};

duet_point_query *duet_point_query_create(const duet_point_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_point_query_def", err))
        return NULL;
    const any_query_def any = {.name = {.item = QUERY_POINTS, .nearest = def->nearest},
                               .filter = def->filter};
    return (duet_point_query *)tree_query_create(def->tree, point_kinds, &any, err);
}

void duet_point_query_destroy(duet_point_query *query)
{
    any_query_destroy((tree_query *)query);
}

static bool run(duet_point_query *query, const void *points, uint64_t n, bool far, const char *call,
                duet_point_query_result *result, duet_error *err)
{
    query_result found;
    if (!error_given(query, call, "query", err) || !error_given(result, call, "result", err) ||
        !tree_query_is_far((tree_query *)query, far, err) ||
        !any_query_run((tree_query *)query, points, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_point_query_result, duet_point_hit, found);
    return true;
}

bool duet_point_query_run(duet_point_query *query, const duet_point *points, uint64_t n,
                          duet_point_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return run(query, points, n, false, __func__, result, err);
}

bool duet_point_query_run_large(duet_point_query *query, const duet_large_point *points, uint64_t n,
                                duet_point_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return run(query, points, n, true, __func__, result, err);
}
