// SPDX-License-Identifier: MIT
// Normals of ray hits: against closed forms, against the gradient of the distance in long double,
// and the same bits on every device.
#include "support/test.h"

#include "support/devices.h"
#include "support/real.h"
#include "support/trees.h"

enum { BOXES = 120, RAYS = 1500 };

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE};

// ---------------------------------------------------------------- truth

// A point along the edges of the core, from its centre.
static void to_core(const duet_rounded_box *box, const long double point[3], long double out[3])
{
    const block core = block_of(&box->pose);
    real way[3];
    real_less(way, point, core.centre);
    for (int i = 0; i < 3; ++i)
        out[i] = real_dot(core.axis[i], way);
}

// From the surface; below 0 inside. edge: how far the nearest face's end is, above 0 beyond it.
static long double distance(const duet_rounded_box *box, const long double point[3], uint32_t dims,
                            long double *edge)
{
    long double p[3], square = 0, deepest = -INFINITY, second = -INFINITY;
    to_core(box, point, p);
    for (uint32_t k = 0; k < dims; ++k) {
        long double beyond = fabsl(p[k]) - box->pose.half_extents[k];
        square += beyond > 0 ? beyond * beyond : 0;
        second = fmaxl(second, fminl(beyond, deepest));
        deepest = fmaxl(deepest, beyond);
    }
    *edge = second;
    return sqrtl(square) + fminl(deepest, 0) - box->radius;
}

static long double distance_at(const duet_rounded_box *box, const duet_ray *ray, long double t,
                               uint32_t dims)
{
    long double point[3], edge;
    for (int k = 0; k < 3; ++k)
        point[k] = ray->origin[k] + t * ray->direction[k];
    return distance(box, point, dims, &edge);
}

// The distance is convex along the ray. False where the ray hardly comes in.
static bool find_entry(const duet_rounded_box *box, const duet_ray *ray, uint32_t dims,
                       long double *entry)
{
    long double from = 0, to = fminf(ray->t_max, 100);
    for (int i = 0; i < 200; ++i) {
        long double a = from + (to - from) / 3, b = to - (to - from) / 3;
        if (distance_at(box, ray, a, dims) < distance_at(box, ray, b, dims))
            to = b;
        else
            from = a;
    }
    if (distance_at(box, ray, from, dims) > -1e-3L)
        return false;
    long double out = 0, in = from;
    for (int i = 0; i < 200; ++i) {
        long double middle = (out + in) / 2;
        if (distance_at(box, ray, middle, dims) > 0)
            out = middle;
        else
            in = middle;
    }
    *entry = out;
    return true;
}

// By differences, a little before the ray enters; false beside an edge without a radius.
static bool find_gradient(const duet_rounded_box *box, const duet_ray *ray, long double t,
                          uint32_t dims, long double gradient[3])
{
    const long double step = 1e-6L;
    long double point[3], edge = 0, length = 0;
    for (int k = 0; k < 3; ++k)
        length += (long double)ray->direction[k] * ray->direction[k];
    for (int k = 0; k < 3; ++k)
        point[k] = ray->origin[k] + (t - 4 * step / sqrtl(length)) * ray->direction[k];
    distance(box, point, dims, &edge);
    for (uint32_t k = 0; k < 3; ++k) {
        long double there[3] = {point[0], point[1], point[2]}, unused;
        there[k] += step;
        gradient[k] = distance(box, there, dims, &unused);
        there[k] -= 2 * step;
        gradient[k] = (gradient[k] - distance(box, there, dims, &unused)) / (2 * step);
    }
    return box->radius > 0.01f || edge < -1e-3L;
}

// ---------------------------------------------------------------- random ones

typedef struct crowd {
    duet_rounded_box boxes[BOXES];
    duet_ray rays[RAYS];
} crowd;

// Boxes, rounded ones, capsules and spheres; in 2D they turn in the plane.
static crowd *draw_crowd(uint64_t seed, uint32_t dims, bool round, bool upright)
{
    crowd *c = test_alloc(sizeof *c);
    rng r = rng_seed(seed);
    for (uint32_t i = 0; i < BOXES; ++i) {
        duet_rounded_box *box = &c->boxes[i];
        box->radius = round && i % 5 > 0 ? (float)rng_between(&r, 0.1, 0.5) : 0;
        for (int k = 0; k < 4; ++k)
            box->pose.rotation[k] =
                upright || (dims == 2 && k < 2) ? k == 3 : (float)rng_normal(&r);
        for (int k = 0; k < 3; ++k) {
            bool thin = box->radius > 0 && (i % 5 == 1 || (i % 5 == 2 && k > 0));
            box->pose.centre[k] = (float)rng_between(&r, -5, 5);
            box->pose.half_extents[k] = thin ? 0 : (float)rng_between(&r, 0.1, 0.7);
        }
    }
    for (uint32_t i = 0; i < RAYS; ++i) {
        duet_ray *ray = &c->rays[i];
        for (int k = 0; k < 3; ++k) {
            ray->origin[k] = (float)rng_between(&r, -7, 7);
            ray->direction[k] = (float)rng_normal(&r);
        }
        ray->t_max = i % 4 ? INFINITY : (float)rng_between(&r, 1, 9);
    }
    return c;
}

static void assert_normal(const crowd *c, const duet_ray_hit *hit, const float normal[3],
                          uint32_t dims, uint32_t *compared)
{
    const duet_ray *ray = &c->rays[hit->ray];
    const duet_rounded_box *box = &c->boxes[hit->id];
    double length = 0, along = 0;
    long double t, gradient[3];
    bool outside = distance_at(box, ray, 0, dims) > 0;
    for (int k = 0; k < 3; ++k) {
        length += (double)normal[k] * normal[k];
        along += (double)normal[k] * ray->direction[k];
    }
    assert_float_equal(length, outside, 1e-6);
    assert_true(along <= 1e-6);
    assert_true(dims == 3 || normal[2] == 0);
    if (!outside || !find_entry(box, ray, dims, &t) || !find_gradient(box, ray, t, dims, gradient))
        return;
    ++*compared;
    for (int k = 0; k < 3; ++k)
        if (!(fabsl(gradient[k] - normal[k]) < 2e-4L))
            fail_msg("ray %u, box %u: the normal is %g %g %g; expected %Lg %Lg %Lg", hit->ray,
                     hit->id, (double)normal[0], (double)normal[1], (double)normal[2], gradient[0],
                     gradient[1], gradient[2]);
}

static duet_tree *open_shape(duet_shape shape, uint32_t dims, uint32_t share, const crowd *c)
{
    duet_pose poses[BOXES];
    duet_bounds bounds[BOXES];
    for (int i = 0; i < BOXES; ++i) {
        poses[i] = c->boxes[i].pose;
        bounds[i] = bounds_of_upright(&poses[i]);
    }
    return shape == DUET_SHAPE_POSES ? open_tree(dims, share, poses, BOXES)
           : shape == DUET_SHAPE_BOUNDS
               ? open_bounds_tree(dims, share, bounds, BOXES)
               : open_rounded_tree(dims, share, DUET_OBJECT_ROUNDED_BOXES, c->boxes, BOXES);
}

// At each share the hits are those of a query without normals, and the normals have the same bits.
static void compare_normals(duet_shape shape, uint32_t dims, duet_query_wants wants)
{
    uint32_t compared = 0;
    duet_ray_normal *known = NULL;
    crowd *c = draw_crowd(test_seed() + dims + shape, dims, shape == DUET_SHAPE_ROUNDED_BOXES,
                          shape == DUET_SHAPE_BOUNDS);
    for (int s = 0; s < 3; ++s) {
        duet_tree *tree = open_shape(shape, dims, shares[s], c);
        duet_ray_query *with = open_ray_query(tree, wants, true),
                       *plain = open_ray_query(tree, wants, false);
        duet_ray_query_result found = cast_rays(with, c->rays, RAYS);
        duet_ray_query_result bare = cast_rays(plain, c->rays, RAYS);
        size_t bytes = found.n_hits * sizeof *known;
        assert_null(bare.normals);
        assert_int_equal(bare.n_hits, found.n_hits);
        assert_memory_equal(bare.hits, found.hits, found.n_hits * sizeof *found.hits);
        for (uint64_t i = 0; s == 0 && i < found.n_hits; ++i)
            if (found.hits[i].id != DUET_NO_OBJECT)
                assert_normal(c, &found.hits[i], found.normals[i].normal, dims, &compared);
            else
                assert_memory_equal(&found.normals[i], &(duet_ray_normal){{0}}, sizeof *known);
        if (s == 0)
            known = test_alloc(bytes);
        if (s == 0)
            memcpy(known, found.normals, bytes);
        assert_memory_equal(known, found.normals, bytes);
    }
    assert_true(compared > RAYS / 20);
}

TEST(normals_are_the_gradient_of_the_distance)
{
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int shape = 0; shape < DUET_SHAPE_SPHERES; ++shape) {
            compare_normals((duet_shape)shape, dims, DUET_QUERY_CLOSEST);
            compare_normals((duet_shape)shape, dims, DUET_QUERY_EVERY);
        }
}

// ---------------------------------------------------------------- closed forms

typedef struct known_hit {
    duet_rounded_box box;
    duet_ray ray;
    float normal[3];
} known_hit;

#define UPRIGHT    \
    {              \
        0, 0, 0, 1 \
    }
#define ROOT_HALF 0.70710678f

static const known_hit knowns[] = {
    // a box: its six faces, then turned by 45 degrees about z
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{5, 1, 1}, {-1, 0, 0}, 9}, {1, 0, 0}},
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{-5, 1, 1}, {2, 0, 0}, 9}, {-1, 0, 0}},
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{0, 5, 1}, {0, -1, 0}, 9}, {0, 1, 0}},
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{0, -5, 1}, {0, 1, 0}, 9}, {0, -1, 0}},
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{0, 0, 5}, {0.1f, 0, -1}, 9}, {0, 0, 1}},
    {{{{0}, {1, 2, 3}, UPRIGHT}, 0}, {{0, 0, -5}, {0, 0, 1}, 9}, {0, 0, -1}},
    {{{{0}, {1, 1, 1}, {0, 0, 0.38268343f, 0.92387953f}}, 0},
     {{5, 0.5f, 0}, {-1, 0, 0}, 9},
     {ROOT_HALF, ROOT_HALF, 0}},
    // a sphere, met off its centre
    {{{{1, 1, 1}, {0}, UPRIGHT}, 5}, {{4, 9, 1}, {0, -1, 0}, 9}, {0.6f, 0.8f, 0}},
    // a capsule along z: its side and its end
    {{{{0}, {0, 0, 2}, UPRIGHT}, 5}, {{9, 3, 1}, {-1, 0, 0}, 9}, {0.8f, 0.6f, 0}},
    {{{{0}, {0, 0, 2}, UPRIGHT}, 5}, {{3, 0, 9}, {0, 0, -1}, 9}, {0.6f, 0, 0.8f}},
    // a rounded cube: face, edge, corner
    {{{{0}, {2, 2, 2}, UPRIGHT}, 3}, {{1, 1, 9}, {0, 0, -1}, 9}, {0, 0, 1}},
    {{{{0}, {2, 2, 2}, UPRIGHT}, 5}, {{5, 1, 19}, {0, 0, -1}, 19}, {0.6f, 0, 0.8f}},
    {{{{0}, {2, 2, 2}, UPRIGHT}, 3}, {{4, 4, 9}, {0, 0, -1}, 9}, {2 / 3.f, 2 / 3.f, 1 / 3.f}},
    // a radius that is rounding's alone
    {{{{0}, {2, 2, 2}, UPRIGHT}, 1e-30f}, {{1, 1, 9}, {0, 0, -1}, 9}, {0, 0, 1}},
};

TEST(normals_have_their_closed_forms)
{
    for (size_t i = 0; i < sizeof knowns / sizeof *knowns; ++i) {
        const known_hit *k = &knowns[i];
        for (int as_box = 0; as_box <= (k->box.radius == 0); ++as_box) {
            duet_tree *tree = as_box
                                  ? open_tree(3, 0, &k->box.pose, 1)
                                  : open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, &k->box, 1);
            duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, true);
            duet_ray_query_result found = cast_rays(query, &k->ray, 1);
            assert_int_equal(found.hits[0].id, 0);
            for (int x = 0; x < 3; ++x)
                assert_float_equal(found.normals[0].normal[x], k->normal[x], 1e-6);
        }
    }
}

// An ulp decides, on every kind of surface.
TEST(a_ray_that_begins_on_a_surface_has_no_normal)
{
    const duet_rounded_box cube = {{{0}, {1, 1, 1}, UPRIGHT}, 0}, ball = {{{0}, {0}, UPRIGHT}, 5};
    const duet_bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
    for (int i = 0; i < 4; ++i) {
        duet_tree *tree = i == 0   ? open_tree(3, 0, &cube.pose, 1)
                          : i == 1 ? open_bounds_tree(3, 0, &bounds, 1)
                                   : open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES,
                                                       i == 2 ? &cube : &ball, 1);
        duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, true);
        duet_ray on = {{1, 0.25f, 0}, {-1, 0, 0}, INFINITY};
        if (i == 3)
            on = (duet_ray){{3, 4, 0}, {-3, -4, 0}, INFINITY};
        duet_ray rays[3] = {on, on, on};
        rays[1].origin[0] = nextafterf(on.origin[0], INFINITY);
        rays[2].origin[0] = nextafterf(on.origin[0], 0);
        duet_ray_query_result found = cast_rays(query, rays, 3);
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(found.hits[k].id, 0);
            assert_float_equal(found.normals[k].normal[0], k != 1 ? 0 : i == 3 ? 0.6 : 1, 1e-6);
            assert_float_equal(found.normals[k].normal[1], k == 1 && i == 3 ? 0.8 : 0, 1e-6);
        }
    }
}

// ---------------------------------------------------------------- far away

TEST(a_scene_moved_by_whole_cells_has_the_same_normals)
{
    enum { N = 300 };
    crowd *c = draw_crowd(test_seed(), 3, false, false);
    duet_ray_normal known[N];
    duet_large_pose boxes[BOXES];
    duet_large_ray rays[N];
    for (int away = 0; away < 2; ++away) {
        const int32_t cell[3] = {away * 900000000, 0, -away * 123456789};
        duet_tree_def def = duet_default_tree_def();
        def.pair = default_pair();
        def.origin_edge = 4;
        duet_tree *tree = kept(duet_tree_create(&def, ERR));
        for (int i = 0; i < BOXES; ++i) {
            boxes[i] = (duet_large_pose){.pose = c->boxes[i].pose};
            memcpy(boxes[i].cell, cell, sizeof cell);
        }
        for (int i = 0; i < N; ++i) {
            rays[i] = (duet_large_ray){.ray = c->rays[i]};
            memcpy(rays[i].cell, cell, sizeof cell);
        }
        must(duet_tree_set_objects(tree, DUET_OBJECT_LARGE_POSES, boxes, BOXES, ERR));
        duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, true);
        duet_ray_query_result found;
        must(duet_ray_query_run_large(query, rays, N, &found, ERR));
        uint32_t compared = 0;
        for (int i = 0; i < N; ++i)
            if (found.hits[i].id != DUET_NO_OBJECT)
                assert_normal(c, &found.hits[i], found.normals[i].normal, 3, &compared);
        assert_true(compared > N / 20);
        if (away == 0)
            memcpy(known, found.normals, sizeof known);
        assert_memory_equal(known, found.normals, sizeof known);
    }
}

TEST(any_hit_has_no_normal)
{
    const duet_pose box = {{0}, {1, 1, 1}, UPRIGHT};
    duet_ray_query_def def = duet_default_ray_query_def();
    duet_tree *tree = def.tree = open_tree(3, 0, &box, 1);
    def.wants = DUET_QUERY_ANY;
    def.normals = true;
    must_fail(duet_ray_query_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "normals with wants any");
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, true);
    assert_null(cast_rays(query, NULL, 0).normals);
}
