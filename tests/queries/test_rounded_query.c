// SPDX-License-Identifier: MIT
// Boxes with a radius in a tree: rays, points and boxes against a sweep over all of them on the
// host, and the exact answer about a ray against the least distance in long double.
#include "support/test.h"

#include "support/devices.h"
#include "support/hits.h"
#include "support/real.h"
#include "support/trees.h"

#include "runtime/narrowphase/rounded.h"
#include "runtime/queries/ray.h"

enum { BOXES = 250, RAYS = 500, NEAREST = 5 };

#define U 0x1p-24

typedef struct world {
    duet_rounded_box boxes[BOXES];
    duet_sphere spheres[BOXES];
    duet_ray rays[RAYS];
    duet_point points[RAYS];
} world;

// Every third ray goes along an axis between round numbers, so that it touches; some are short, and
// some a point.
static world *make_world(void)
{
    world *w = test_alloc(sizeof *w);
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < BOXES; ++i) {
        w->boxes[i] = draw_rounded(&r, i);
        memcpy(w->spheres[i].centre, w->boxes[i].pose.centre, sizeof w->spheres[i].centre);
        w->spheres[i].radius = w->boxes[i].radius;
    }
    for (uint32_t i = 0; i < RAYS; ++i) {
        duet_ray *ray = &w->rays[i];
        double scale = exp2(rng_between(&r, -20, 20));
        for (int k = 0; k < 3; ++k) {
            double at = rng_between(&r, -6, 6);
            ray->origin[k] = (float)(i % 3 == 0 ? round(at * 4) / 4 : at);
            ray->direction[k] = i % 3 == 0 ? (float)(k == (int)(i / 3 % 3)) * (i % 2 ? 1 : -1)
                                           : (float)(scale * rng_normal(&r));
            w->points[i].at[k] = ray->origin[k];
        }
        ray->t_max = i % 5 == 0 ? INFINITY : (float)(rng_between(&r, 0, 8) / (i % 3 ? scale : 1));
        if (i % 31 == 0)
            memset(ray->direction, 0, sizeof ray->direction);
    }
    return w;
}

// All lengths times a power of two.
static void scale_world(world *w, float scale)
{
    for (uint32_t i = 0; i < BOXES; ++i) {
        w->boxes[i].radius *= scale;
        for (int k = 0; k < 3; ++k) {
            w->boxes[i].pose.centre[k] *= scale;
            w->boxes[i].pose.half_extents[k] *= scale;
        }
    }
    for (uint32_t i = 0; i < RAYS; ++i) {
        w->rays[i].t_max *= scale;
        for (int k = 0; k < 3; ++k)
            w->rays[i].origin[k] *= scale;
    }
}

// ---------------------------------------------------------------- long double

// From the core, at t of the ray.
static real distance_at(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims, real t)
{
    const duet_pose pose = narrow_flat(&box->pose, dims);
    real axis[3][3], square = 0;
    real_axes(axis, pose.rotation);
    for (uint32_t i = 0; i < dims; ++i) {
        real at = 0;
        for (uint32_t k = 0; k < dims; ++k)
            at += axis[i][k] * ((real)ray->origin[k] - pose.centre[k] + t * ray->direction[k]);
        real beyond = fmaxl(fabsl(at) - pose.half_extents[i], 0);
        square += beyond * beyond;
    }
    return sqrtl(square);
}

static real size_of(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims)
{
    real size = box->radius;
    for (uint32_t k = 0; k < dims; ++k)
        size += fabsl((real)ray->origin[k] - box->pose.centre[k]) + box->pose.half_extents[k];
    return size;
}

// By thirds, since the distance is convex.
static real least_distance(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims)
{
    real length = 0;
    for (uint32_t k = 0; k < dims; ++k)
        length += (real)ray->direction[k] * ray->direction[k];
    if (length == 0)
        return distance_at(ray, box, dims, 0);
    real from = 0, to = fminl(ray->t_max, 4 * size_of(ray, box, dims) / sqrtl(length));
    for (int step = 0; step < 200; ++step) {
        real a = from + (to - from) / 3, b = to - (to - from) / 3;
        if (distance_at(ray, box, dims, a) <= distance_at(ray, box, dims, b))
            to = b;
        else
            from = a;
    }
    return fminl(distance_at(ray, box, dims, from), distance_at(ray, box, dims, to));
}

TEST(integers_agree_with_the_least_distance)
{
    world *w = make_world();
    uint32_t near = 0, clear = 0;
    for (uint32_t i = 0; i < RAYS; i += 3 + i % 2)
        for (uint32_t id = i % 3; id < BOXES; id += 3) {
            uint32_t dims = 2 + id % 2;
            const duet_rounded_box *box = &w->boxes[id];
            float t = 0;
            bool is_met = ray_meets_rounded(&w->rays[i], box, dims, &t);
            real over = least_distance(&w->rays[i], box, dims) - box->radius;
            bool told = fabsl(over) > 1e-14L * size_of(&w->rays[i], box, dims);
            if (told && is_met != (over < 0))
                fail_msg("ray %u and box %u in %uD: %s, %.3Lg apart", i, id, dims,
                         is_met ? "meets" : "misses", over);
            near += is_met;
            clear += told;
        }
    assert_true(near > 100 && clear > 1000);
}

// ---------------------------------------------------------------- rays

// By integers, unless a sphere around the box is far from the ray.
static bool meets(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims)
{
    real reach = box->radius, along = 0, length = 0, square = 0;
    float t = 0;
    for (uint32_t k = 0; k < dims; ++k) {
        reach += box->pose.half_extents[k];
        along += ray->direction[k] * ((real)box->pose.centre[k] - ray->origin[k]);
        length += (real)ray->direction[k] * ray->direction[k];
    }
    real at = length > 0 ? fminl(fmaxl(along / length, 0), ray->t_max) : 0;
    real size = size_of(ray, box, dims);
    for (uint32_t k = 0; k < dims; ++k) {
        real way = (real)ray->origin[k] + at * ray->direction[k] - box->pose.centre[k];
        square += way * way;
    }
    return square <= 1.1L * reach * reach + 1e-9L * size * size &&
           ray_meets_rounded(ray, box, dims, &t);
}

// Every hit is one of the host's, and lies where the ray comes as near as the radius.
static void check_rays(const world *w, const duet_rounded_box *boxes, uint32_t dims,
                       const duet_ray_query_result *found)
{
    hit_list hits = HITS(*found, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id, meets(&w->rays[i], &boxes[id], dims));
    expect_no_more(&hits, RAYS / 10);
    for (const duet_ray_hit *h = found->hits; h < found->hits + found->n_hits; ++h) {
        const duet_ray *ray = &w->rays[h->ray];
        const duet_rounded_box *box = &boxes[h->id];
        real size = size_of(ray, box, dims);
        real apart = distance_at(ray, box, dims, h->t) - box->radius;
        real begin = distance_at(ray, box, dims, 0) - box->radius;
        assert_true(h->t >= 0 && h->t <= ray->t_max);
        if (apart > 128 * U * size || (h->t > 0 && begin > 0 && apart < -128 * U * size) ||
            (h->t > 0 && begin < -128 * U * size))
            fail_msg("ray %u enters box %u at %g in %uD: %.3Lg u S from it, begin %.3Lg", h->ray,
                     h->id, (double)h->t, dims, apart / (real)(U * size), begin);
    }
    assert_true(found->undecided < found->n_hits / 2);
}

static void rays_in(const world *w, duet_tree *tree, const duet_rounded_box *boxes, uint32_t dims)
{
    duet_ray_query *every = open_ray_query(tree, DUET_QUERY_EVERY, false);
    duet_ray_query *closest = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    duet_ray_query_result all = cast_rays(every, w->rays, RAYS),
                          first = cast_rays(closest, w->rays, RAYS);
    check_rays(w, boxes, dims, &all);
    hit_list hits = HITS(all, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i) {
        const duet_ray_hit none = {i, DUET_NO_OBJECT, INFINITY}, *nearest = take_hits(&hits, i);
        assert_memory_equal(&first.hits[i], nearest ? nearest : &none, sizeof none);
    }
}

TEST(rays_meet_what_the_host_says)
{
    world *w = make_world();
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_tree *tree =
            open_rounded_tree(dims, DUET_SHARE_ONE / 3, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
        rays_in(w, tree, w->boxes, dims);
    }
}

// A ray that begins in a sphere, nearer to its surface than float sees, and goes along it: whether
// it comes nearer or goes away is rounding.
TEST(rays_that_begin_at_a_surface_meet_it)
{
    const duet_rounded_box spheres[] = {
        {{{-0x1.122f76p-1f, 0x1.14ea64p-1f, 0x1.b295c4p-3f},
          {0, 0, 0},
          {0x1.ddd4e4p+0f, 0x1.493692p-1f, 0x1.a8c094p-3f, 0x1.e362dcp+0f}},
         5},
        {{{-0x1.8c3708p-1f, 0x1.daa66p-2f, 0x1.70bedp-4f},
          {0, 0, 0},
          {0x1.82029ap-10f, 0x1.78ac02p-1f, 0x1.ec191ep-2f, 0x1.85d938p-2f}},
         5},
        {{{0x1.2bfb84p-4f, -0x1.4aac1ep-1f, -0x1.bde034p-2f},
          {0, 0, 0},
          {0x1.42718cp-2f, -0x1.7f9ed6p+0f, -0x1.d1439p-3f, -0x1.a277e2p-1f}},
         5},
    };
    const duet_ray rays[] = {
        {{0x1.445ad4p+0f, 0x1.95ecacp+0f, -0x1.1550b2p+2f},
         {0x1.a8adfap-1f, 0x1.7ef544p-2f, 0x1.a8dcf2p-2f},
         2},
        {{0x1.c434dcp+0f, -0x1.282f3ep-1f, 0x1.11320ap+2f},
         {0x1.3623ep-1f, -0x1.34e9ecp-1f, -0x1.0992ccp-1f},
         2},
        {{0x1.9a43b4p+0f, -0x1.4fe5c8p+2f, -0x1.a6a6p+0f},
         {-0x1.2a819ap-1f, 0x1.54597ap-6f, -0x1.9fd7aap-1f},
         2},
    };
    for (uint32_t i = 0; i < 3; ++i) {
        duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, &spheres[i], 1);
        duet_ray_query *query = open_ray_query(tree, DUET_QUERY_EVERY, false);
        assert_true(distance_at(&rays[i], &spheres[i], 3, 0) < 5);
        duet_ray_query_result found = cast_rays(query, &rays[i], 1);
        if (found.n_hits != 1)
            fail_msg("ray %u misses the sphere in which it begins", i);
        assert_true(distance_at(&rays[i], &spheres[i], 3, found.hits[0].t) < 5.0001L);
    }
}

// Squares of such lengths are no floats.
TEST(rays_of_any_scale_meet_as_many)
{
    const float scales[] = {0x1p75f, 0x1p-60f};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
        world *w = make_world();
        scale_world(w, scales[i]);
        duet_tree *tree =
            open_rounded_tree(3, DUET_SHARE_ONE / 3, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
        rays_in(w, tree, w->boxes, 3);
    }
}

// ---------------------------------------------------------------- points

static void check_nearest(const world *w, const duet_rounded_box *boxes, uint32_t dims,
                          const duet_point_hit *hits, uint32_t i)
{
    const duet_ray ray = {.origin = {w->points[i].at[0], w->points[i].at[1], w->points[i].at[2]}};
    real last = 0;
    bool is_near[BOXES] = {false};
    for (int k = 0; k < NEAREST; ++k) {
        const duet_rounded_box *box = &boxes[hits[k].id];
        real distance = fmaxl(distance_at(&ray, box, dims, 0) - box->radius, 0);
        assert_true(hits[k].point == i && hits[k].distance >= last && !is_near[hits[k].id]);
        if (fabsl(distance - hits[k].distance) > 128 * U * size_of(&ray, box, dims))
            fail_msg("point %u is %.9Lg from box %u in %uD, not %.9g", i, distance, hits[k].id,
                     dims, (double)hits[k].distance);
        is_near[hits[k].id] = true;
        last = hits[k].distance;
    }
    for (uint32_t id = 0; id < BOXES; ++id) {
        real distance = fmaxl(distance_at(&ray, &boxes[id], dims, 0) - boxes[id].radius, 0);
        assert_true(is_near[id] || distance >= last - 256 * U * size_of(&ray, &boxes[id], dims));
    }
}

static void points_in(const world *w, duet_tree *tree, const duet_rounded_box *boxes, uint32_t dims)
{
    duet_point_query *containing = open_point_query(tree, 0);
    duet_point_query *nearest = open_point_query(tree, NEAREST);
    duet_point_query_result found = seek_points(containing, w->points, RAYS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id) {
            duet_ray ray = {.t_max = 0};
            memcpy(ray.origin, w->points[i].at, sizeof ray.origin);
            expect_hit(&hits, i, id, meets(&ray, &boxes[id], dims));
        }
    expect_no_more(&hits, 20);
    found = seek_points(nearest, w->points, RAYS);
    for (uint32_t i = 0; i < RAYS; ++i)
        check_nearest(w, boxes, dims, found.hits + (size_t)i * NEAREST, i);
}

TEST(points_are_in_and_near_what_the_host_says)
{
    world *w = make_world();
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_tree *tree =
            open_rounded_tree(dims, DUET_SHARE_ONE / 3, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
        points_in(w, tree, w->boxes, dims);
    }
}

// ---------------------------------------------------------------- boxes

// Half of the boxes are asked about, then all of them against each other.
static void boxes_in(duet_tree *tree, duet_object_kind kind, const void *objects,
                     const duet_rounded_box *boxes, uint32_t dims)
{
    duet_box_query_result found;
    duet_box_query *query = open_box_query(tree);
    for (int itself = 0; itself < 2; ++itself) {
        uint32_t n = itself ? BOXES : BOXES / 2;
        must(itself ? duet_box_query_run_itself(query, NULL, 0, &found, ERR)
                    : duet_box_query_run(query, kind, objects, n, &found, ERR));
        hit_list hits = HITS(found, BOXES);
        for (uint32_t i = 0; i < n; ++i)
            for (uint32_t id = 0; id < BOXES; ++id)
                expect_hit(&hits, i, id,
                           (!itself || id > i) && rounded_decide(&boxes[i], &boxes[id], dims));
        expect_no_more(&hits, 5);
    }
}

TEST(boxes_collide_as_a_worlds)
{
    world *w = make_world();
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_tree *tree =
            open_rounded_tree(dims, DUET_SHARE_ONE / 3, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
        boxes_in(tree, DUET_OBJECT_ROUNDED_BOXES, w->boxes, w->boxes, dims);
    }
}

// Spheres are rounded boxes without a core.
TEST(spheres_are_asked_about_as_rounded_boxes)
{
    world *w = make_world();
    duet_rounded_box rounded[BOXES];
    for (uint32_t i = 0; i < BOXES; ++i)
        rounded[i] = rounded_of_sphere(&w->spheres[i]);
    duet_tree *tree =
        open_rounded_tree(3, DUET_SHARE_ONE / 3, DUET_OBJECT_SPHERES, w->spheres, BOXES);
    rays_in(w, tree, rounded, 3);
    boxes_in(tree, DUET_OBJECT_SPHERES, w->spheres, rounded, 3);
}

// ---------------------------------------------------------------- a motion's bodies

static duet_motion *open_motion(const world *w, uint32_t wants, bool doubles)
{
    duet_motion_def def = duet_default_motion_def();
    duet_pose *poses = test_alloc(BOXES * sizeof *poses);
    duet_body *bodies = test_alloc(BOXES * sizeof *bodies);
    for (uint32_t i = 0; i < BOXES; ++i) {
        poses[i] = w->boxes[i].pose;
        bodies[i] = duet_default_body();
        bodies[i].radius = w->boxes[i].radius;
        bodies[i].velocity[i % 3] = 1.0f / 8;
    }
    def.pair = default_pair();
    def.doubles = doubles;
    def.wants = wants;
    return kept(duet_motion_create(&def, poses, bodies, BOXES, ERR));
}

// One gets another radius, one leaves, one is disabled, and one comes.
static void change_bodies(duet_motion *motion, duet_rounded_box boxes[BOXES + 1])
{
    duet_body wide = duet_default_body(), come = duet_default_body();
    uint64_t id = 0;
    const duet_body_list removed = {.first = 5, .n = 1}, disabled = {.first = 6, .n = 1};
    wide.radius = 1.5f;
    come.radius = 2;
    boxes[4].radius = wide.radius;
    boxes[BOXES] = (duet_rounded_box){{{1, 1, 1}, {0}, {0, 0, 0, 1}}, come.radius};
    must(duet_motion_set_bodies(motion, (duet_body_list){.first = 4, .n = 1}, DUET_BODY_RADIUS,
                                &wide, ERR));
    must(duet_motion_remove_bodies(motion, removed, ERR));
    must(duet_motion_disable_bodies(motion, disabled, ERR));
    must(duet_motion_add_bodies(motion, &boxes[BOXES].pose, &come, 1, &id, ERR));
    assert_int_equal(id, BOXES);
}

static void assert_same_rays(const world *w, duet_tree *tree, duet_tree *by_hand)
{
    duet_ray_query *asked = open_ray_query(tree, DUET_QUERY_EVERY, false);
    duet_ray_query *known = open_ray_query(by_hand, DUET_QUERY_EVERY, false);
    duet_ray_query_result found = cast_rays(asked, w->rays, RAYS),
                          expected = cast_rays(known, w->rays, RAYS);
    assert_true(expected.n_hits > RAYS / 10);
    assert_int_equal(found.n_hits, expected.n_hits);
    assert_memory_equal(found.hits, expected.hits, expected.n_hits * sizeof *expected.hits);
}

// By hand: the poses that the motion tells, with the radii that it was given; what is left out is
// where no ray goes.
static void ask_bodies(const world *w, duet_motion *motion)
{
    duet_motion_result result;
    duet_rounded_box boxes[BOXES + 1];
    duet_pose poses[BOXES + 1];
    duet_tree *trees[2], *by_hand = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, NULL, 0);
    for (uint32_t i = 0; i < 2; ++i) // B alone, and both
        trees[i] = open_rounded_tree(3, DUET_SHARE_ONE / 3 * i, DUET_OBJECT_ROUNDED_BOXES, NULL, 0);
    memcpy(boxes, w->boxes, sizeof w->boxes);
    for (int step = 0; step < 3; ++step) {
        if (step == 2)
            change_bodies(motion, boxes);
        uint32_t n = duet_motion_get_count(motion);
        must(duet_motion_get_poses(motion, poses, ERR));
        for (uint32_t i = 0; i < n; ++i)
            boxes[i].pose = poses[i];
        if (step == 2)
            boxes[5] = boxes[6] = (duet_rounded_box){{{1000, 1000, 1000}, {0}, {0, 0, 0, 1}}, 0};
        must(duet_tree_set_objects(by_hand, DUET_OBJECT_ROUNDED_BOXES, boxes, n, ERR));
        for (int i = 0; i < 2; ++i) {
            must(duet_tree_set_motion(trees[i], motion, ERR));
            assert_same_rays(w, trees[i], by_hand);
        }
        must(duet_motion_advance(motion, &result, ERR));
    }
}

TEST(a_tree_of_a_motion_has_its_radii)
{
    world *w = make_world();
    ask_bodies(w, open_motion(w, DUET_EFFECT_CONTACT, false));
    ask_bodies(w, open_motion(w, DUET_EFFECT_CONTACT, true));
    ask_bodies(w, open_motion(w, 0, false)); // by way of the host
}

// Bodies with radii, bodies that may get some, boxes, and boxes in origin cells.
TEST(the_def_of_a_motion_makes_a_tree_that_takes_it)
{
    const duet_pose pose = {{0, 0, 2}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_ray ray = {{0, 0, 9}, {0, 0, -1}, 9};
    duet_body body = duet_default_body();
    for (uint32_t i = 0; i < 16; ++i) {
        bool round = i & 1, wants = i & 2, flat = i & 4, cells = i & 8;
        duet_motion_def def = duet_default_motion_def();
        def.pair = default_pair();
        def.dims = flat ? 2 : 3;
        def.wants = wants ? DUET_EFFECT_RADIUS : 0;
        def.origin_edge = cells ? 4 : 0;
        body.radius = round ? 0.25f : 0;
        duet_motion *motion = kept(duet_motion_create(&def, &pose, &body, 1, ERR));
        duet_tree_def of_motion = duet_motion_tree_def(motion);
        of_motion.share = 0;
        duet_tree *tree = kept(duet_tree_create(&of_motion, ERR));
        must(duet_tree_set_motion(tree, motion, ERR));
        if (!flat && of_motion.origin_edge == 0) {
            duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
            assert_float_equal(cast_rays(query, &ray, 1).hits[0].t, round ? 6.25 : 6.5, 1e-5);
        }
    }
    assert_null(duet_motion_tree_def(NULL).pair);
}

// Poses are rounded boxes without a radius.
TEST(a_tree_of_rounded_boxes_takes_bodies_without_radii)
{
    world *w = make_world();
    for (uint32_t i = 0; i < BOXES; ++i)
        w->boxes[i].radius = 0;
    duet_motion *motion = open_motion(w, DUET_EFFECT_CONTACT, false);
    duet_pose poses[BOXES];
    must(duet_motion_get_poses(motion, poses, ERR));
    for (uint32_t i = 0; i < BOXES; ++i)
        w->boxes[i].pose = poses[i];
    duet_tree *by_hand = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
    duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, NULL, 0);
    must(duet_tree_set_motion(tree, motion, ERR));
    assert_same_rays(w, tree, by_hand);
}

// ---------------------------------------------------------------- refusals

TEST(what_is_no_rounded_box_is_refused)
{
    const duet_rounded_box good = {{{0}, {1, 1, 1}, {0, 0, 0, 1}}, 0.5f};
    duet_rounded_box boxes[3] = {good, good, good};
    duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, boxes, 3);
    const float wrong[] = {-1, NAN, INFINITY, 0x1p101f};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        boxes[1].radius = wrong[i];
        must_fail(duet_tree_set_objects(tree, DUET_OBJECT_ROUNDED_BOXES, boxes, 3, ERR),
                  DUET_STATUS_BAD_OBJECT, "object 1 ");
    }
    must_fail(duet_tree_set_objects(tree, DUET_OBJECT_POSES, boxes, 3, ERR),
              DUET_STATUS_BAD_ARGUMENT, "the tree is of rounded boxes");
}
