// SPDX-License-Identifier: MIT
// Rays against boxes: every hit against a sweep over all boxes in exact arithmetic, the
// other two questions against every hit, and the same bits on every device and share.
#include "support/test.h"

#include "support/devices.h"
#include "support/hits.h"
#include "support/real.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"

// With a tree of its own.
static duet_ray_query *open_alone(duet_query_wants wants, uint32_t dims, uint32_t share,
                                  const duet_pose *poses, uint32_t n)
{
    duet_tree *tree = open_tree(dims, share, poses, n);
    return open_ray_query(tree, wants, false);
}

// ---------------------------------------------------------------- worlds

enum { BOXES = 500, RAYS = 1500 };

static float between(rng *r, double from, double to)
{
    return (float)rng_between(r, from, to);
}

// Boxes of sizes from a thousandth to a third of the world; every fourth stands upright.
static void fill_boxes(rng *r, duet_pose *poses, uint32_t n, uint32_t dims)
{
    for (uint32_t i = 0; i < n; ++i) {
        float size = between(r, 0, 1) < 0.02f ? 3.0f : 0.01f * powf(50, between(r, 0, 1));
        memset(&poses[i], 0, sizeof poses[i]);
        for (uint32_t k = 0; k < 3; ++k) {
            poses[i].centre[k] = between(r, -5, 5);
            poses[i].half_extents[k] = size * between(r, 0.3, 1);
        }
        if (i % 4 == 0)
            poses[i].centre[0] = roundf(poses[i].centre[0]);
        for (uint32_t k = 0; k < 4; ++k)
            poses[i].rotation[k] = i % 4 == 0 || (dims == 2 && k < 2) ? 0 : (float)rng_normal(r);
        if (i % 4 == 0)
            poses[i].rotation[3] = 1;
    }
}

// A point of the box's surface, exactly so where the box stands upright.
static void point_on(rng *r, const duet_pose *box, float point[3])
{
    for (int k = 0; k < 3; ++k) {
        float side = rng_below(r, 2) ? 1.0f : -1.0f;
        point[k] = box->centre[k] + side * box->half_extents[k];
    }
}

// Some go anywhere, some along an axis, some begin where boxes are, many aim at corners and
// end there, and some stand still.
static void fill_rays(rng *r, duet_ray *rays, uint32_t n, const duet_pose *boxes, uint32_t n_boxes)
{
    for (uint32_t i = 0; i < n; ++i) {
        duet_ray *ray = &rays[i];
        float target[3];
        point_on(r, &boxes[rng_below(r, n_boxes)], target);
        for (int k = 0; k < 3; ++k) {
            ray->origin[k] = between(r, -8, 8);
            ray->direction[k] = i % 3 == 0 ? between(r, -1, 1) : target[k] - ray->origin[k];
        }
        ray->t_max = i % 3 == 0 ? INFINITY : i % 3 == 1 ? 1.0f : between(r, 0, 2);
        if (i % 7 == 0) { // along an axis, touching a face or an edge
            memcpy(ray->origin, target, sizeof target);
            ray->origin[i % 2] -= 16;
            memset(ray->direction, 0, sizeof ray->direction);
            ray->direction[i % 2] = i % 14 == 0 ? 1 : 0.0625f;
            ray->t_max = i % 21 == 0 ? 16.0f : INFINITY;
        }
        if (i % 11 == 0)
            memset(ray->direction, 0, sizeof ray->direction);
        if (i % 13 == 0)
            ray->direction[i % 3] *= 1e-20f;
        if (i % 17 == 0)
            for (int k = 0; k < 3; ++k)
                ray->direction[k] *= 0x1p60f;
    }
}

typedef struct world {
    duet_pose boxes[BOXES];
    duet_ray rays[RAYS];
} world;

static world *make_world(uint32_t dims)
{
    world *w = test_alloc(sizeof *w);
    rng r = rng_seed(test_seed());
    fill_boxes(&r, w->boxes, BOXES, dims);
    fill_rays(&r, w->rays, RAYS, w->boxes, BOXES);
    return w;
}

// ---------------------------------------------------------------- truth

// Finds where a ray enters a box, in long double; the ray is known to meet it.
static long double enters_at(const duet_ray *ray, const duet_pose *box, uint32_t dims,
                             long double *least_speed)
{
    const duet_pose flat = narrow_flat(box, dims);
    real axis[3][3], enter = 0;
    real_axes(axis, flat.rotation);
    *least_speed = 1;
    for (uint32_t i = 0; i < dims; ++i) {
        long double at = 0, speed = 0;
        for (uint32_t k = 0; k < dims; ++k) {
            at += axis[i][k] * ((real)ray->origin[k] - box->centre[k]);
            speed += axis[i][k] * ray->direction[k];
        }
        if (fabsl(speed) < 1e-30L)
            continue;
        long double in = (-box->half_extents[i] - (speed > 0 ? at : -at)) / fabsl(speed);
        if (in > enter) {
            enter = in;
            *least_speed = fabsl(speed);
        }
    }
    return enter;
}

static long double size_of(const duet_ray *ray, const duet_pose *box, uint32_t dims)
{
    long double size = 0;
    for (uint32_t k = 0; k < dims; ++k)
        size += fabsl((long double)ray->origin[k] - box->centre[k]) + box->half_extents[k];
    return size;
}

// The point at t is as near to the box's face as docs/accuracy.md promises.
static void assert_enters_there(const duet_ray *ray, const duet_pose *box, uint32_t dims, float t)
{
    long double speed;
    long double enter = enters_at(ray, box, dims, &speed);
    long double size = size_of(ray, box, dims);
    long double error = fabsl(t - enter) * speed;
    if (error > 128 * 0x1p-24L * size)
        fail_msg("t %.9g, expected %.9Lg: off by %.3Lg of a size of %.3Lg", (double)t, enter, error,
                 size);
}

static void every_hit_is_found_and_no_other(uint32_t dims, uint32_t share)
{
    world *w = make_world(dims);
    duet_ray_query *query = open_alone(DUET_QUERY_EVERY, dims, share, w->boxes, BOXES);
    duet_ray_query_result found = cast_rays(query, w->rays, RAYS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id,
                       (i + id) % 16 == 0 || has_hit(&hits, i, id)
                           ? ray_meets_exactly(&w->rays[i], &w->boxes[id], dims)
                           : ray_meets(&w->rays[i], &w->boxes[id], dims));
    expect_no_more(&hits, RAYS);
    for (const duet_ray_hit *hit = found.hits; hit < found.hits + found.n_hits; ++hit) {
        assert_true(hit->t >= 0 && hit->t <= w->rays[hit->ray].t_max);
        assert_enters_there(&w->rays[hit->ray], &w->boxes[hit->id], dims, hit->t);
    }
    assert_true(found.undecided > 0);
    print_message("%uD: %" PRIu64 " hits, %" PRIu64 " undecided\n", dims, found.n_hits,
                  found.undecided);
}

TEST(every_hit_in_3d)
{
    every_hit_is_found_and_no_other(3, DUET_SHARE_ONE / 3);
}

TEST(every_hit_in_2d)
{
    every_hit_is_found_and_no_other(2, 0);
}

// ---------------------------------------------------------------- bounds

// Some are flat, or points; corners of many are whole numbers, as those of neighbours are.
static void fill_bounds(rng *r, duet_bounds *bounds, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i)
        for (int k = 0; k < 3; ++k) {
            float lower = between(r, -5, 5), size = i % 9 == 0 ? 0 : between(r, 0, 1);
            bounds[i].lower[k] = i % 3 == 0 ? roundf(lower) : lower;
            bounds[i].upper[k] = bounds[i].lower[k] + (i % 3 == 0 ? roundf(2 * size) : size);
        }
}

// Finds where a ray enters bounds that it meets.
static long double enters_bounds_at(const duet_ray *ray, const duet_bounds *box, uint32_t dims)
{
    long double enter = 0;
    for (uint32_t k = 0; k < dims; ++k) {
        long double speed = ray->direction[k];
        if (speed != 0)
            enter = fmaxl(
                enter, ((speed > 0 ? box->lower[k] : box->upper[k]) - (long double)ray->origin[k]) /
                           speed);
    }
    return enter;
}

static bool ray_meets_bounds(const duet_ray *ray, const duet_bounds *box, uint32_t dims)
{
    duet_bounds_sweep sweep = {.t_max = ray->t_max};
    for (int k = 0; k < 3; ++k) {
        sweep.bounds.lower[k] = sweep.bounds.upper[k] = ray->origin[k];
        sweep.direction[k] = ray->direction[k];
    }
    return sweep_meets_bounds(&sweep, box, dims);
}

static void hits_of_bounds_are_exact_in(uint32_t dims)
{
    world *w = make_world(dims);
    duet_bounds bounds[BOXES];
    rng r = rng_seed(test_seed() + 1);
    fill_bounds(&r, bounds, BOXES);
    for (uint32_t i = 0; i < RAYS; i += 3) // begin and end on corners
        for (int k = 0; k < 3; ++k)
            w->rays[i].origin[k] =
                i % 2 ? bounds[i % BOXES].upper[k] : roundf(w->rays[i].origin[k]);
    duet_tree *tree = open_bounds_tree(dims, DUET_SHARE_ONE / 3, bounds, BOXES);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_EVERY, false);
    duet_ray_query_result found = cast_rays(query, w->rays, RAYS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id, ray_meets_bounds(&w->rays[i], &bounds[id], dims));
    expect_no_more(&hits, RAYS / 2);
    for (const duet_ray_hit *hit = found.hits; hit < found.hits + found.n_hits; ++hit) {
        long double enter = enters_bounds_at(&w->rays[hit->ray], &bounds[hit->id], dims);
        if (fabsl(hit->t - enter) > 8 * 0x1p-24L * enter)
            fail_msg("t %.9g, expected %.9Lg", (double)hit->t, enter);
    }
}

TEST(hits_of_bounds_are_exact)
{
    hits_of_bounds_are_exact_in(3);
    hits_of_bounds_are_exact_in(2);
}

// Towards the faces across y the ray is too slow for float: the host finds where it enters.
TEST(a_slow_ray_enters_bounds_where_it_does)
{
    const float slow = 0x1p-70f;
    const duet_bounds bounds[] = {{{0, 2 * slow, 0}, {4, 1, 1}}, {{1, 0, 0}, {4, 1, 1}}};
    const duet_ray ray = {{0, 0, 0}, {1, slow, 0}, INFINITY};
    duet_tree *tree = open_bounds_tree(3, 0, bounds, 2);
    duet_ray_query *closest = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    duet_ray_query *every = open_ray_query(tree, DUET_QUERY_EVERY, false);
    duet_ray_hit first = cast_rays(closest, &ray, 1).hits[0];
    duet_ray_query_result all = cast_rays(every, &ray, 1);
    assert_int_equal(first.id, 1);
    assert_true(first.t == 1);
    assert_int_equal(all.n_hits, 2);
    assert_int_equal(all.hits[0].id, 1);
    assert_int_equal(all.hits[1].id, 0);
    assert_true(all.hits[1].t == 2);
}

// A box that is not turned is bounds too, where its corners are floats.
TEST(integers_agree_on_poses_and_bounds)
{
    rng r = rng_seed(test_seed() + 2);
    for (int i = 0; i < 20000; ++i) {
        duet_pose pose = {.rotation = {0, 0, 0, 1}};
        duet_bounds bounds;
        duet_ray ray = {.t_max = i % 3 == 0 ? INFINITY : (float)rng_below(&r, 4)};
        for (int k = 0; k < 3; ++k) {
            pose.centre[k] = (float)rng_below(&r, 8);
            pose.half_extents[k] = (float)rng_below(&r, 3);
            bounds.lower[k] = pose.centre[k] - pose.half_extents[k];
            bounds.upper[k] = pose.centre[k] + pose.half_extents[k];
            ray.origin[k] = (float)rng_below(&r, 8);
            ray.direction[k] = (float)rng_below(&r, 5) - 2;
        }
        assert_int_equal(ray_meets_bounds(&ray, &bounds, 3), ray_meets_exactly(&ray, &pose, 3));
    }
}

// ---------------------------------------------------------------- the other two questions

TEST(closest_and_any_are_of_every_hit)
{
    world *w = make_world(3);
    duet_ray_query *every = open_alone(DUET_QUERY_EVERY, 3, 0, w->boxes, BOXES);
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 2, w->boxes, BOXES);
    duet_ray_query *closest = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    duet_ray_query *any = open_ray_query(tree, DUET_QUERY_ANY, false);
    test_give_back(tree);
    duet_ray_query_result all = cast_rays(every, w->rays, RAYS);
    duet_ray_query_result nearest = cast_rays(closest, w->rays, RAYS);
    duet_ray_query_result some = cast_rays(any, w->rays, RAYS);
    assert_int_equal(nearest.n_hits, RAYS);
    assert_int_equal(some.n_hits, RAYS);
    hit_list hits = HITS(all, BOXES);
    for (uint32_t i = 0; i < RAYS; ++i) {
        const duet_ray_hit none = {i, DUET_NO_OBJECT, INFINITY}, *first = take_hits(&hits, i);
        assert_memory_equal(&nearest.hits[i], first ? first : &none, sizeof none);
        const duet_ray_hit yes = {i, first ? 0 : DUET_NO_OBJECT, 0};
        assert_memory_equal(&some.hits[i], &yes, sizeof yes);
    }
}

TEST(share_and_order_of_boxes_change_nothing)
{
    world *w = make_world(3);
    duet_ray_query *one = open_alone(DUET_QUERY_CLOSEST, 3, 0, w->boxes, BOXES);
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE, w->boxes, BOXES);
    duet_ray_query *two = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    duet_ray_query_result a = cast_rays(one, w->rays, RAYS), b = cast_rays(two, w->rays, RAYS);
    assert_memory_equal(a.hits, b.hits, RAYS * sizeof *a.hits);
    assert_int_equal(a.undecided, b.undecided);
    // Another box first makes another tree.
    duet_pose *turned = test_alloc(sizeof w->boxes);
    for (uint32_t id = 0; id < BOXES; ++id)
        turned[id] = w->boxes[(id + 77) % BOXES];
    set_poses(tree, turned, BOXES);
    b = cast_rays(two, w->rays, RAYS);
    for (uint32_t i = 0; i < RAYS; ++i) {
        assert_true(a.hits[i].t == b.hits[i].t);
        assert_true((a.hits[i].id == DUET_NO_OBJECT) == (b.hits[i].id == DUET_NO_OBJECT));
    }
    test_give_back(turned);
    // A query of a tree that gets other shares, the first being A's alone.
    const uint32_t shares[] = {DUET_SHARE_ONE / 3, 0, DUET_SHARE_DEFAULT, DUET_SHARE_ONE};
    set_poses(tree, w->boxes, BOXES);
    for (size_t i = 0; i < sizeof shares / sizeof *shares; ++i) {
        must(duet_tree_set_share(tree, shares[i], ERR));
        b = cast_rays(two, w->rays, RAYS);
        assert_memory_equal(a.hits, b.hits, RAYS * sizeof *a.hits);
        if (shares[i] != DUET_SHARE_DEFAULT)
            assert_true((b.device_ms[0] > 0) == (shares[i] > 0));
        if (i == 0)
            assert_true(b.device_ms[1] > 0);
    }
}

// ---------------------------------------------------------------- moving worlds

// A body falls through the ray; the motion goes on as one that nobody asks about.
TEST(rays_meet_bodies_where_they_are)
{
    const duet_pose start = {{5, 0, 2}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_ray ray = {{0, 0, 0}, {1, 0, 0}, INFINITY};
    duet_motion_def def = duet_default_motion_def();
    duet_motion *asked[2];
    duet_motion_result result;
    def.pair = default_pair();
    def.gravity[2] = -10;
    for (int i = 0; i < 2; ++i)
        asked[i] = kept(duet_motion_create(&def, &start, NULL, 1, ERR));
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    uint32_t met = 0;
    for (int step = 0; step < 60; ++step) {
        duet_state where;
        duet_pose pose;
        must(duet_motion_advance(asked[0], &result, ERR));
        must(duet_motion_advance(asked[1], &result, ERR));
        must(duet_motion_get_states(asked[1], &where, ERR));
        must(duet_motion_get_poses(asked[0], &pose, ERR));
        set_poses(tree, &pose, 1);
        bool meets = fabs(where.centre[2]) <= 0.5;
        assert_int_equal(cast_rays(query, &ray, 1).hits[0].id, meets ? 0 : DUET_NO_OBJECT);
        met += meets;
    }
    assert_true(met > 5 && met < 50);
    uint64_t hashes[2];
    for (int i = 0; i < 2; ++i)
        must(duet_motion_get_hash(asked[i], &hashes[i], ERR));
    assert_true(hashes[0] == hashes[1]);
}

enum { BODIES = 40 };

// Turned boxes above a floor, body 0. `doubles` and contact: what the state is in, and whether B
// has the bodies' sizes.
static duet_motion *drop_boxes(bool doubles, bool contact)
{
    rng r = rng_seed(test_seed() + 4);
    duet_motion_def def = duet_default_motion_def();
    duet_pose poses[BODIES] = {{{0, 0, -1}, {20, 20, 1}, {0, 0, 0, 1}}};
    duet_body bodies[BODIES] = {duet_default_body()};
    bodies[0].mass = 0;
    for (int i = 1; i < BODIES; ++i) {
        poses[i] = (duet_pose){{between(&r, -5, 5), between(&r, -5, 5), between(&r, 1, 5)},
                               {0.5f, 0.25f, between(&r, 0.1, 0.6)},
                               {between(&r, -1, 1), between(&r, -1, 1), 0.5f, 1}};
        bodies[i] = duet_default_body();
    }
    def.pair = default_pair();
    def.doubles = doubles;
    def.gravity[2] = -10;
    def.wants = contact ? DUET_EFFECT_CONTACT_RESPONSE : 0;
    return kept(duet_motion_create(&def, poses, bodies, BODIES, ERR));
}

// Some leave, some come, and what is left out has a pose that no ray meets.
static void change_bodies(duet_motion *motion)
{
    const duet_body_list removed = {.first = 5, .n = 6}, disabled = {.first = 20, .n = 3};
    const duet_pose added = {{0, 0, 3}, {2, 2, 0.5f}, {0, 0, 0, 1}};
    uint64_t id;
    must(duet_motion_remove_bodies(motion, removed, ERR));
    must(duet_motion_disable_bodies(motion, disabled, ERR));
    must(duet_motion_add_bodies(motion, &added, NULL, 1, &id, ERR));
}

static void set_bodies(duet_tree *tree, duet_motion *motion, bool changed)
{
    duet_pose poses[BODIES + 1];
    uint32_t n = duet_motion_get_count(motion);
    assert_true(n <= BODIES + 1);
    must(duet_motion_get_poses(motion, poses, ERR));
    for (uint32_t i = 0; changed && i < n; ++i)
        if ((i >= 5 && i < 11) || (i >= 20 && i < 23))
            poses[i] = (duet_pose){{1000, 1000, 1000}, {0}, {0, 0, 0, 1}};
    set_poses(tree, poses, n);
}

static void meet_the_bodies_of(bool doubles, bool contact)
{
    world *w = make_world(3);
    duet_motion_result result;
    duet_motion *asked = drop_boxes(doubles, contact), *alone = drop_boxes(doubles, contact);
    duet_tree *by_host = open_tree(3, 0, NULL, 0), *trees[3];
    duet_ray_query *expected = open_ray_query(by_host, DUET_QUERY_EVERY, false), *queries[3];
    for (uint32_t i = 0; i < 3; ++i) {
        trees[i] = open_tree(3, DUET_SHARE_ONE / 2 * i, NULL, 0);
        queries[i] = open_ray_query(trees[i], DUET_QUERY_EVERY, false);
    }
    for (int step = 0; step < 12; ++step) {
        if (step == 6) {
            change_bodies(asked);
            change_bodies(alone);
        }
        set_bodies(by_host, asked, step >= 6);
        duet_ray_query_result known = cast_rays(expected, w->rays, 300);
        assert_true(known.n_hits > 0);
        for (int i = 0; i < 3; ++i) {
            must(duet_tree_set_motion(trees[i], asked, ERR));
            duet_ray_query_result found = cast_rays(queries[i], w->rays, 300);
            assert_int_equal(found.n_hits, known.n_hits);
            assert_memory_equal(found.hits, known.hits, known.n_hits * sizeof *known.hits);
        }
        must(duet_motion_advance(asked, &result, ERR));
        must(duet_motion_advance(alone, &result, ERR));
    }
    set_bodies(by_host, asked, true);
    must(duet_tree_set_motion(trees[2], asked, ERR));
    must(duet_tree_set_motion(trees[0], asked, ERR));
    must(duet_tree_set_share(trees[2], 0, ERR));
    must(duet_tree_set_share(trees[0], DUET_SHARE_ONE, ERR));
    duet_ray_query_result known = cast_rays(expected, w->rays, 300);
    for (int i = 0; i < 3; i += 2) {
        duet_ray_query_result found = cast_rays(queries[i], w->rays, 300);
        assert_int_equal(found.n_hits, known.n_hits);
        assert_memory_equal(found.hits, known.hits, known.n_hits * sizeof *known.hits);
    }
    uint64_t hashes[2];
    must(duet_motion_get_hash(asked, &hashes[0], ERR));
    must(duet_motion_get_hash(alone, &hashes[1], ERR));
    assert_true(hashes[0] == hashes[1]);
    test_give_back(asked);
    test_give_back(alone);
    for (int i = 0; i < 3; ++i) { // a tree outlives its motion
        cast_rays(queries[i], w->rays, 300);
    }
}

TEST(a_tree_of_a_motion_has_its_bodies)
{
    meet_the_bodies_of(false, true);
    meet_the_bodies_of(true, true);
    meet_the_bodies_of(false, false); // by way of the host
}

TEST(a_motion_that_no_tree_takes_is_refused)
{
    duet_motion_def def = duet_default_motion_def();
    const duet_pose far[2] = {{{0, 0, 0}, {1, 1, 1}, {0, 0, 0, 1}},
                              {{0x1p101f, 0, 0}, {1, 1, 1}, {0, 0, 0, 1}}};
    def.pair = default_pair();
    def.wants = DUET_EFFECT_CONTACT;
    duet_motion *motion = kept(duet_motion_create(&def, far, NULL, 2, ERR));
    duet_tree *bounds = open_bounds_tree(3, 0, NULL, 0), *flat = open_tree(2, 0, NULL, 0);
    duet_tree *tree = open_tree(3, 0, &far[0], 1);
    must_fail(duet_tree_set_motion(bounds, motion, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text,
                        "a motion's bodies are poses or rounded boxes; the tree is of bounds");
    must_fail(duet_tree_set_motion(flat, motion, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "the motion has dims 3; the tree has 2");
    must_fail(duet_tree_set_motion(tree, motion, ERR), DUET_STATUS_BAD_OBJECT, "object 1 ");
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_ANY, false);
    assert_int_equal(cast_rays(query, &(duet_ray){.t_max = 1}, 1).hits[0].id, DUET_NO_OBJECT);
}

// ---------------------------------------------------------------- closed forms

// A wall of unit cubes on whole numbers: a ray along their common faces touches the cubes
// of both sides, and one along an edge those of four.
TEST(touching_counts)
{
    enum { WIDE = 6 };
    duet_pose cubes[WIDE * WIDE * WIDE];
    for (int i = 0; i < WIDE * WIDE * WIDE; ++i)
        cubes[i] = (duet_pose){{(float)(i % WIDE), (float)(i / WIDE % WIDE), (float)(i / 36)},
                               {0.5f, 0.5f, 0.5f},
                               {0, 0, 0, 1}};
    const struct {
        duet_ray ray;
        uint64_t hits;
    } known[] = {
        {{{-3, 2, 2}, {1, 0, 0}, INFINITY}, WIDE},           // through the centres
        {{{-3, 2.5f, 2}, {1, 0, 0}, INFINITY}, 2 * WIDE},    // along faces
        {{{-3, 2.5f, 2.5f}, {1, 0, 0}, INFINITY}, 4 * WIDE}, // along edges
        {{{-3, 5.5f, 5.5f}, {1, 0, 0}, INFINITY}, WIDE},     // along the outermost edge
        {{{-3, 5.5000005f, 2}, {1, 0, 0}, INFINITY}, 0},
        {{{-3, 2, 2}, {1, 0, 0}, 2.5f}, 1}, // ends at the first face
        {{{-3, 2, 2}, {1, 0, 0}, 2.4999998f}, 0},
        {{{2.5f, 2.5f, 2.5f}, {0, 0, 0}, 1}, 8}, // a corner of eight
        {{{-0.5f, -0.5f, -3}, {0, 0, 1}, INFINITY}, WIDE},
        {{{5, 5, 5}, {1, 1, 1}, INFINITY}, 1},
        {{{-1, -1, -1}, {1, 1, 1}, INFINITY}, WIDE + 6 * (WIDE - 1)}, // the diagonal
        {{{8, 2, 2}, {1, 0, 0}, INFINITY}, 0},                        // behind it
    };
    enum { N = sizeof known / sizeof *known };
    duet_ray rays[N];
    for (int i = 0; i < N; ++i)
        rays[i] = known[i].ray;
    duet_ray_query *query = open_alone(DUET_QUERY_EVERY, 3, 0, cubes, WIDE * WIDE * WIDE);
    duet_ray_query_result found = cast_rays(query, rays, N);
    uint64_t hits[N] = {0};
    for (uint64_t i = 0; i < found.n_hits; ++i)
        ++hits[found.hits[i].ray];
    for (int i = 0; i < N; ++i)
        if (hits[i] != known[i].hits)
            fail_msg("ray %d: %" PRIu64 " hits, expected %" PRIu64, i, hits[i], known[i].hits);
}

// More hits than the lists hold at first.
TEST(lists_grow)
{
    enum { N = 300 };
    duet_pose *boxes = test_alloc(N * sizeof *boxes);
    duet_ray *rays = test_alloc(N * sizeof *rays);
    for (int i = 0; i < N; ++i) {
        boxes[i] = (duet_pose){{0}, {1, 1, 1}, {0, 0, 0, 1}};
        rays[i] = (duet_ray){{i % 2 ? 1.0f : 0.5f, 0, -5}, {0, 0, 1}, INFINITY};
    }
    duet_ray_query *query = open_alone(DUET_QUERY_EVERY, 3, 0, boxes, N);
    duet_ray_query_result found = cast_rays(query, rays, N);
    assert_int_equal(found.n_hits, N * N);
    assert_int_equal(found.undecided, N * N / 2);
    for (uint64_t i = 0; i < found.n_hits; ++i)
        assert_true(found.hits[i].ray == i / N && found.hits[i].id == i % N &&
                    found.hits[i].t == 4);
}

// On GPUs with memory of their own, as the CPU's parts are told here to be, chunks follow each
// other, and a ray goes its own way. In B's second chunk float leaves more open than is read along
// with it.
TEST(chunks_that_follow_each_other_lose_nothing)
{
    enum { FLOW = 1 << 18, N = 2 * FLOW + 5000, CUBES = 27 };
    duet_pose cubes[CUBES];
    duet_ray *rays = test_alloc(N * sizeof *rays);
    duet_ray_hit *expected = test_alloc(N * sizeof *expected);
    rng r = rng_seed(test_seed());
    for (int i = 0; i < CUBES; ++i)
        cubes[i] = (duet_pose){
            {2.0f * (i % 3), 2.0f * (i / 3 % 3), 2.0f * (i / 9)}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    for (int i = 0; i < N; ++i) {
        bool touches = i % (i / FLOW == 1 ? 32 : 512) == 0;
        rays[i] = (duet_ray){
            {-9, touches ? 0.5f : between(&r, -1, 5), between(&r, -1, 5)}, {1, 0, 0}, INFINITY};
    }
    for (int own = 0; own < 2; ++own) {
        devices_seem_gpus(own);
        duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 8, cubes, CUBES);
        duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
        for (int run = 0; run < 1 + own; ++run) { // with lists that were used before, too
            duet_ray_query_result found = cast_rays(query, rays, N - run);
            assert_int_equal(found.n_hits, N - run);
            assert_true(found.undecided > (1 << 12));
            if (!own)
                memcpy(expected, found.hits, N * sizeof *expected);
            assert_memory_equal(found.hits, expected, (N - run) * sizeof *expected);
        }
        if (own) {
            duet_ray_query_result found;
            rays[FLOW + 7].t_max = NAN;
            must_fail(duet_ray_query_run(query, rays, N, &found, ERR), DUET_STATUS_BAD_OBJECT,
                      "ray 262151:");
        }
    }
    devices_seem_gpus(false);
}

TEST(a_gpu_walks_to_the_same_hits)
{
    world *w = make_world(3);
    duet_ray_query *on_cpu = open_alone(DUET_QUERY_CLOSEST, 3, 0, w->boxes, BOXES);
    duet_ray_query_result expected = cast_rays(on_cpu, w->rays, RAYS);
    devices_seem_gpus(true);
    duet_ray_query *on_gpu = open_alone(DUET_QUERY_CLOSEST, 3, 0, w->boxes, BOXES);
    duet_ray_query_result found = cast_rays(on_gpu, w->rays, RAYS);
    assert_memory_equal(found.hits, expected.hits, RAYS * sizeof *found.hits);
    assert_int_equal(found.undecided, expected.undecided);
    test_give_back(on_gpu);
    devices_seem_gpus(false);
}

TEST(no_boxes_and_no_rays_are_no_error)
{
    const duet_pose box = {{0}, {1, 1, 1}, {0, 0, 0, 1}};
    const duet_ray ray = {{0, 0, -5}, {0, 0, 1}, INFINITY};
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    duet_ray_query_result found = cast_rays(query, &ray, 1);
    assert_true(found.n_hits == 1 && found.hits[0].id == DUET_NO_OBJECT);
    set_poses(tree, &box, 1);
    found = cast_rays(query, &ray, 1);
    assert_true(found.n_hits == 1 && found.hits[0].id == 0 && found.hits[0].t == 4);
    assert_int_equal(cast_rays(query, NULL, 0).n_hits, 0);
}

TEST(what_is_no_ray_or_box_is_refused_by_its_number)
{
    const duet_pose good = {{0}, {1, 1, 1}, {0, 0, 0, 1}};
    duet_tree *tree = open_tree(3, 0, &good, 1);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
    const duet_ray bad_rays[] = {{{NAN, 0, 0}, {1, 0, 0}, 1},      {{0, 0, 0}, {INFINITY, 0, 0}, 1},
                                 {{0, 0, 0}, {1, 0, 0}, -1},       {{0, 0, 0}, {1, 0, 0}, NAN},
                                 {{0x1p101f, 0, 0}, {1, 0, 0}, 1}, {{0, 0, 0}, {1e-35f, 0, 0}, 1}};
    for (size_t i = 0; i < sizeof bad_rays / sizeof *bad_rays; ++i) {
        duet_ray_query_result found;
        const duet_ray rays[3] = {{{0}, {1, 0, 0}, 1}, {{0}, {1, 0, 0}, 1}, bad_rays[i]};
        must_fail(duet_ray_query_run(query, rays, 3, &found, ERR), DUET_STATUS_BAD_OBJECT,
                  "ray 2:");
    }
    duet_pose boxes[3] = {good, good, good};
    boxes[1].centre[2] = NAN;
    must_fail(duet_tree_set_objects(tree, DUET_OBJECT_POSES, boxes, 3, ERR), DUET_STATUS_BAD_OBJECT,
              "object 1 ");
    // It has no boxes now.
    const duet_ray ray = {{0, 0, -5}, {0, 0, 1}, INFINITY};
    assert_int_equal(cast_rays(query, &ray, 1).hits[0].id, DUET_NO_OBJECT);
}
