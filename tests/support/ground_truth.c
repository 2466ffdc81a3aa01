// SPDX-License-Identifier: MIT
#include "support/ground_truth.h"

#include "support/test.h"
#include "support/trees.h"

enum { RAYS = 4000, POINTS = 600 };

static duet_ray draw_ray(const ground_truth *t, rng *r)
{
    duet_ray ray = {.t_max = rng_below(r, 4) ? INFINITY : (float)rng_between(r, 0, 6)};
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = (float)rng_between(r, k == 2 ? t->deepest : -7, 7);
        ray.direction[k] = (float)(rng_normal(r) * (t->is_solid && k == 2 ? 0.5 : 1));
    }
    uint32_t kind = (uint32_t)rng_below(r, 8);
    if (kind < 2) // upright, or along an axis
        ray.direction[kind] = ray.direction[kind == 0 ? 1 : 2] = 0;
    else if (kind < 5)
        ray.direction[kind - 2] = 0;
    else if (kind == 5)
        memset(ray.direction, 0, sizeof ray.direction);
    return ray;
}

// A grazing ray's t is known less well: the point there is on the ground all the same.
static void check_ray(const ground_truth *t, const duet_ray *ray, const duet_ray_hit *hit,
                      const float normal[3])
{
    real expected = t->cast(t->ground, ray), square = 0, toward = 0;
    bool met = hit->id != DUET_NO_OBJECT;
    if (met != (expected < INFINITY))
        fail_msg("ray %u: %s, and %Lg", hit->ray, met ? "met" : "missed", expected);
    if (!met)
        return;
    assert_int_equal(hit->id, GROUND_ID);
    if (!(fabsl((real)hit->t - expected) <= 1e-6L * (1 + expected)))
        fail_msg("ray %u enters at %.9g, not %.9Lg", hit->ray, (double)hit->t, expected);
    for (int k = 0; k < 3; ++k) {
        square += (real)normal[k] * (real)normal[k];
        toward += (real)normal[k] * (real)ray->direction[k];
    }
    if (t->is_solid && expected == 0)
        assert_true(square == 0);
    else
        assert_true(fabsl(square - 1) < 1e-6L && (t->is_solid ? toward <= 1e-6L : toward < 0));
}

void ground_truth_check_rays(const ground_truth *t, duet_tree *tree, rng *r)
{
    duet_ray *rays = test_alloc(RAYS * sizeof *rays);
    uint32_t met = 0;
    for (uint32_t i = 0; i < RAYS; ++i)
        rays[i] = draw_ray(t, r);
    duet_ray_query_result found =
        cast_rays(open_ray_query(tree, DUET_QUERY_CLOSEST, true), rays, RAYS);
    for (uint32_t i = 0; i < RAYS; ++i) {
        check_ray(t, &rays[i], &found.hits[i], found.normals[i].normal);
        met += found.hits[i].id != DUET_NO_OBJECT;
    }
    assert_true(met > RAYS / 8 && met < RAYS * 7 / 8);
}

void ground_truth_check_points(const ground_truth *t, duet_tree *tree, rng *r)
{
    duet_point points[POINTS];
    for (uint32_t i = 0; i < POINTS; ++i)
        for (int k = 0; k < 3; ++k)
            points[i].at[k] = (float)rng_between(r, k == 2 ? t->deepest : -11, 11);
    duet_point_query_result found = seek_points(open_point_query(tree, 3), points, POINTS);
    assert_int_equal(found.n_hits, 3 * POINTS);
    for (uint32_t i = 0; i < POINTS; ++i) {
        const duet_point_hit *hit = &found.hits[3 * i];
        const real at[3] = {points[i].at[0], points[i].at[1], points[i].at[2]};
        assert_true(hit[0].distance <= hit[1].distance && hit[2].id == DUET_NO_OBJECT);
        assert_true(hit[0].id + hit[1].id == GROUND_ID + 1 && hit[0].id * hit[1].id == 0);
        real seen = hit[hit[0].id == 0].distance, right = t->distance(t->ground, at);
        if (!(fabsl(seen - right) <= 2e-7L * (1 + right)))
            fail_msg("point %u is %.9Lg from the ground, not %.9Lg", i, seen, right);
    }
}
