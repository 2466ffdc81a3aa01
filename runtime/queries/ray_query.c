// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"
#include "runtime/queries/tree_query.h"

#include <math.h>
#include <string.h>

enum { COOKIE = 0x0d0e700a };

_Static_assert(sizeof(duet_ray) == 7 * sizeof(float), "a ray is seven floats");
_Static_assert(sizeof(duet_large_ray) == 10 * sizeof(float), "and with its cell ten words");
_Static_assert(sizeof(duet_ray_hit) == 3 * sizeof(uint32_t), "a hit is three words");
_Static_assert(sizeof(duet_ray_normal) == 3 * sizeof(float), "a normal is three floats");

duet_ray_query_def duet_default_ray_query_def(void)
{
    return (duet_ray_query_def){.cookie = COOKIE};
}

// Bounds that a ray begins in are a point. Float may have left out an axis along which the ray
// is slow.
static bool meets_bounds(const duet_ray *ray, const duet_bounds *box, uint32_t dims, float *t)
{
    float normal[3];
    duet_bounds_sweep sweep = {.t_max = ray->t_max};
    memcpy(sweep.bounds.lower, ray->origin, sizeof ray->origin);
    memcpy(sweep.bounds.upper, ray->origin, sizeof ray->origin);
    memcpy(sweep.direction, ray->direction, sizeof ray->direction);
    if (!sweep_meets_bounds(&sweep, box, dims))
        return false;
    *t = fmaxf(*t, sweep_enter_bounds(&sweep, box, dims, normal));
    return true;
}

static bool meets(const duet_tree *tree, const void *item, uint32_t *hit)
{
    duet_ray_hit *h = (duet_ray_hit *)hit;
    if (tree->def.shape == DUET_SHAPE_BOUNDS)
        return meets_bounds(item, (const duet_bounds *)tree->objects + h->id, tree->def.dims,
                            &h->t);
    if (tree->def.shape == DUET_SHAPE_POSES)
        return ray_meets(item, (const duet_pose *)tree->objects + h->id, tree->def.dims);
    return ray_meets_rounded(item, (const duet_rounded_box *)tree->objects + h->id, tree->def.dims,
                             &h->t);
}

static bool meets_far(const duet_tree *tree, const void *item, uint32_t *hit)
{
    const duet_large_ray *ray = item;
    const duet_large_pose *box = (const duet_large_pose *)tree->objects + hit[1];
    double shift[3];
    far_shift(shift, box, ray->cell, tree->def.origin_edge);
    return ray_meets_apart(&ray->ray, &box->pose, shift, tree->def.dims);
}

static void normal(const duet_tree *tree, const void *item, const uint32_t *hit, float out[3])
{
    const uint32_t id = hit[1], dims = tree->def.dims;
    if (tree->def.shape == DUET_SHAPE_BOUNDS)
        ray_normal_of_bounds(item, (const duet_bounds *)tree->objects + id, dims, out);
    else if (tree->def.shape == DUET_SHAPE_POSES)
        ray_normal(item, (const duet_pose *)tree->objects + id, narrow_here, dims, out);
    else
        ray_normal_of_rounded(item, (const duet_rounded_box *)tree->objects + id, dims, out);
}

static void normal_far(const duet_tree *tree, const void *item, const uint32_t *hit, float out[3])
{
    const duet_large_ray *ray = item;
    const duet_large_pose *box = (const duet_large_pose *)tree->objects + hit[1];
    double shift[3];
    far_shift(shift, box, ray->cell, tree->def.origin_edge);
    ray_normal(&ray->ray, &box->pose, shift, tree->def.dims, out);
}

static bool meets_ground(const tree_query *q, const void *item, uint32_t *hit)
{
    const duet_ray *ray = item;
    duet_ray_hit *h = (duet_ray_hit *)hit;
    const ground_probe probe = ground_probe_of_ray(ray);
    ground_entry entry;
    if (!ground_shape_meet(&q->tree->ground, &probe, &entry))
        return false;
    h->t = fminf((float)entry.t, ray->t_max);
    return true;
}

static void ground_normal(const duet_tree *tree, const void *item, const uint32_t *hit,
                          float out[3])
{
    const duet_ray *ray = item;
    const ground_probe probe = ground_probe_of_ray(ray);
    ground_entry entry;
    (void)hit;
    if (ground_shape_meet(&tree->ground, &probe, &entry) && entry.t > 0.0)
        ground_set_normal(&entry, out);
}

#define RAYS(type_, wrong_, meets_, normal_)                                                  \
    {                                                                                         \
        .item = "ray", .items = "rays", .wrong = (wrong_), .kernel = "ray_query",             \
        .item_words = QUERY_WORDS(type_), .item_cell = QUERY_WORDS(duet_ray), .hit_words = 3, \
        .meets = (meets_), .normal = (normal_), .meets_ground = meets_ground,                 \
        .ground_normal = ground_normal                                                        \
    }
#define NEAR_RAYS                                                                            \
    RAYS(duet_ray,                                                                           \
         "not a number, an origin or direction above 2^100, a direction below 2^-100, or a " \
         "t_max below 0",                                                                    \
         meets, normal)

const query_kinds ray_kinds = {
    NEAR_RAYS, NEAR_RAYS, NEAR_RAYS, NEAR_RAYS,
    RAYS(duet_large_ray,
         "not a number, an origin beyond 2^30 origin cells, a direction above 2^100 or below "
         "2^-100, or a t_max below 0",
         meets_far, normal_far)};

duet_ray_query *duet_ray_query_create(const duet_ray_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_ray_query_def", err))
        return NULL;
    const any_query_def any = {.name = {.item = QUERY_RAYS, .wants = def->wants},
                               .normals = def->normals,
                               .filter = def->filter};
    return (duet_ray_query *)tree_query_create(def->tree, ray_kinds, &any, err);
}

void duet_ray_query_destroy(duet_ray_query *query)
{
    any_query_destroy((tree_query *)query);
}

static bool run(duet_ray_query *query, const void *rays, uint64_t n, bool far, const char *call,
                duet_ray_query_result *result, duet_error *err)
{
    query_result found;
    if (!error_given(query, call, "query", err) || !error_given(result, call, "result", err) ||
        !tree_query_is_far((tree_query *)query, far, err) ||
        !any_query_run((tree_query *)query, rays, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_ray_query_result, duet_ray_hit, found);
    result->normals = (const duet_ray_normal *)found.normals;
    return true;
}

bool duet_ray_query_run(duet_ray_query *query, const duet_ray *rays, uint64_t n,
                        duet_ray_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return run(query, rays, n, false, __func__, result, err);
}

bool duet_ray_query_run_large(duet_ray_query *query, const duet_large_ray *rays, uint64_t n,
                              duet_ray_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return run(query, rays, n, true, __func__, result, err);
}
