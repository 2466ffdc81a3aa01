// SPDX-License-Identifier: MIT
// Points: which boxes contain them against exact arithmetic, and the nearest ones against a
// sweep over all boxes in long double.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/hits.h"
#include "support/trees.h"

#include "runtime/queries/ray.h"

enum { BOXES = 400, POINTS = 900, NEAREST = 7 };

typedef struct world {
    duet_pose boxes[BOXES];
    duet_bounds bounds[BOXES];
    duet_point points[POINTS];
} world;

// Every fourth box stands upright on round numbers; every third point is a corner of one, some
// are far away.
static world *make_world(void)
{
    world *w = test_alloc(sizeof *w);
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < BOXES; ++i) {
        float size = i % 50 == 0 ? 4 : i % 11 == 0 ? 0.001f : 0.5f;
        for (int k = 0; k < 4; ++k) {
            w->boxes[i].rotation[k] = i % 4 == 0 ? k == 3 : (float)rng_normal(&r);
            if (k == 3)
                break;
            w->boxes[i].centre[k] = (float)rng_between(&r, -5, 5);
            w->boxes[i].half_extents[k] = size * (float)rng_between(&r, 0.1, 1);
            if (i % 4 == 0) {
                w->boxes[i].centre[k] = roundf(w->boxes[i].centre[k]);
                w->boxes[i].half_extents[k] = 0.5f;
            }
            w->bounds[i].lower[k] = w->boxes[i].centre[k] - w->boxes[i].half_extents[k];
            w->bounds[i].upper[k] = w->boxes[i].centre[k] + w->boxes[i].half_extents[k];
        }
    }
    for (uint32_t i = 0; i < POINTS; ++i)
        for (int k = 0; k < 3; ++k) {
            const duet_bounds *b = &w->bounds[rng_below(&r, BOXES / 4) * 4];
            w->points[i].at[k] = (float)rng_between(&r, -6, 6) * (i % 40 == 0 ? 1000 : 1);
            if (i % 3 == 0)
                w->points[i].at[k] = rng_below(&r, 2) ? b->lower[k] : b->upper[k];
        }
    return w;
}

// ---------------------------------------------------------------- containing

static bool contains(const world *w, bool bounds, uint32_t id, const duet_point *p, uint32_t dims)
{
    duet_ray ray = {{p->at[0], p->at[1], p->at[2]}, {0}, 0};
    bool inside = true;
    for (uint32_t k = 0; k < dims; ++k)
        inside = inside && w->bounds[id].lower[k] <= p->at[k] && p->at[k] <= w->bounds[id].upper[k];
    return bounds ? inside : ray_meets_exactly(&ray, &w->boxes[id], dims);
}

static void containing_boxes_are_exact_in(duet_tree *tree, const world *w, bool bounds,
                                          uint32_t dims)
{
    duet_point_query *query = open_point_query(tree, 0);
    duet_point_query_result found = seek_points(query, w->points, POINTS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < POINTS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id, contains(w, bounds, id, &w->points[i], dims));
    expect_no_more(&hits, POINTS / 4);
    for (uint64_t k = 0; k < found.n_hits; ++k)
        assert_true(found.hits[k].distance == 0);
    assert_true(bounds == (found.undecided == 0));
}

TEST(containing_boxes_are_exact)
{
    world *w = make_world();
    const uint32_t third = DUET_SHARE_ONE / 3;
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        containing_boxes_are_exact_in(open_tree(dims, third, w->boxes, BOXES), w, false, dims);
        containing_boxes_are_exact_in(open_bounds_tree(dims, third, w->bounds, BOXES), w, true,
                                      dims);
    }
}

// ---------------------------------------------------------------- nearest

// How far a point is from a box, and the size that the error is a part of.
static long double distance_to(const duet_pose *box, const duet_point *p, uint32_t dims,
                               long double *size)
{
    const float *q = box->rotation;
    long double x = dims == 3 ? q[0] : 0, y = dims == 3 ? q[1] : 0, z = q[2], v = q[3];
    long double norm = x * x + y * y + z * z + v * v, square = 0;
    const long double axis[3][3] = {
        {v * v + x * x - y * y - z * z, 2 * (x * y + v * z), 2 * (x * z - v * y)},
        {2 * (x * y - v * z), v * v + y * y - x * x - z * z, 2 * (y * z + v * x)},
        {2 * (x * z + v * y), 2 * (y * z - v * x), v * v + z * z - x * x - y * y}};
    *size = 0;
    for (uint32_t i = 0; i < dims; ++i) {
        long double at = 0;
        for (uint32_t k = 0; k < dims; ++k)
            at += axis[i][k] / norm * ((long double)p->at[k] - box->centre[k]);
        long double beyond = fmaxl(fabsl(at) - box->half_extents[i], 0);
        square += beyond * beyond;
        *size += fabsl((long double)p->at[i] - box->centre[i]) + box->half_extents[i];
    }
    return sqrtl(square);
}

static long double distance_to_bounds(const duet_bounds *box, const duet_point *p, uint32_t dims)
{
    long double square = 0;
    for (uint32_t k = 0; k < dims; ++k) {
        long double beyond =
            fmaxl((long double)box->lower[k] - p->at[k], (long double)p->at[k] - box->upper[k]);
        square += beyond > 0 ? beyond * beyond : 0;
    }
    return sqrtl(square);
}

// The error that docs/accuracy.md allows.
static long double error_of(const world *w, bool bounds, uint32_t id, const duet_point *p,
                            uint32_t dims, long double *distance)
{
    long double size;
    *distance = distance_to(&w->boxes[id], p, dims, &size);
    if (bounds)
        *distance = distance_to_bounds(&w->bounds[id], p, dims);
    return bounds ? 8 * 0x1p-24L * *distance : 48 * 0x1p-24L * size;
}

// Each is as far away as it says, none comes twice, and none that was left out is nearer.
static void check_nearest(const world *w, bool bounds, const duet_point_hit *hits, uint32_t i,
                          uint32_t dims)
{
    const duet_point *p = &w->points[i];
    bool listed[BOXES] = {false};
    long double distance;
    for (int k = 0; k < NEAREST; ++k) {
        const duet_point_hit *hit = &hits[k];
        assert_true(hit->point == i && hit->id < BOXES && !listed[hit->id]);
        listed[hit->id] = true;
        long double error = error_of(w, bounds, hit->id, p, dims, &distance);
        if (fabsl(hit->distance - distance) > error)
            fail_msg("point %u, box %u: %.9g, expected %.9Lg within %.3Lg", i, hit->id,
                     (double)hit->distance, distance, error);
        assert_true(k == 0 || hits[k - 1].distance < hit->distance ||
                    (hits[k - 1].distance == hit->distance && hits[k - 1].id < hit->id));
    }
    for (uint32_t id = 0; id < BOXES; ++id) {
        long double error = error_of(w, bounds, id, p, dims, &distance);
        assert_true(listed[id] || distance + error >= hits[NEAREST - 1].distance);
    }
}

static void nearest_boxes_are_near_in(duet_tree *tree, const world *w, bool bounds, uint32_t dims)
{
    duet_point_query *query = open_point_query(tree, NEAREST);
    duet_point_query_result found = seek_points(query, w->points, POINTS);
    assert_int_equal(found.n_hits, POINTS * NEAREST);
    for (uint32_t i = 0; i < POINTS; ++i)
        check_nearest(w, bounds, found.hits + (size_t)i * NEAREST, i, dims);
}

TEST(nearest_boxes_are_near)
{
    world *w = make_world();
    const uint32_t third = DUET_SHARE_ONE / 3;
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        nearest_boxes_are_near_in(open_tree(dims, third, w->boxes, BOXES), w, false, dims);
        nearest_boxes_are_near_in(open_bounds_tree(dims, third, w->bounds, BOXES), w, true, dims);
    }
}

TEST(share_and_order_of_boxes_change_nothing)
{
    world *w = make_world();
    duet_pose turned[BOXES];
    for (uint32_t id = 0; id < BOXES; ++id)
        turned[id] = w->boxes[(id + 77) % BOXES];
    duet_tree *one = open_tree(3, 0, w->boxes, BOXES);
    duet_tree *two = open_tree(3, DUET_SHARE_ONE, w->boxes, BOXES);
    duet_point_query *of_one = open_point_query(one, NEAREST),
                     *of_two = open_point_query(two, NEAREST);
    duet_point_query_result a = seek_points(of_one, w->points, POINTS);
    duet_point_query_result b = seek_points(of_two, w->points, POINTS);
    assert_memory_equal(a.hits, b.hits, POINTS * NEAREST * sizeof *a.hits);
    set_poses(two, turned, BOXES);
    b = seek_points(of_two, w->points, POINTS);
    for (uint32_t i = 0; i < POINTS * NEAREST; ++i)
        assert_true(a.hits[i].distance == b.hits[i].distance);
}

// Hard boxes of all sizes, from near and from far: the error is looked for where it is large.
TEST(distances_keep_their_bound_on_hard_boxes)
{
    enum { N = 600 };
    static duet_pose boxes[N];
    static duet_point points[N];
    rng r = rng_seed(test_seed());
    uint32_t n_classes = 0, n = 0;
    long double worst = 0;
    while (hard_classes[n_classes].name)
        ++n_classes;
    for (uint32_t i = 0; i < N; ++i) {
        duet_pose box = hard_classes[i % n_classes].make(&r, 3).a;
        bool usual = true;
        for (int k = 0; k < 3; ++k)
            usual = usual && fabsf(box.centre[k]) < 0x1p40f && box.half_extents[k] < 0x1p40f &&
                    (box.half_extents[k] == 0 || box.half_extents[k] > 0x1p-40f);
        if (!usual)
            continue;
        for (int k = 0; k < 3; ++k) // beside a corner
            points[n].at[k] = box.centre[k] + (float)rng_between(&r, -2, 2) * box.half_extents[k];
        boxes[n++] = box;
    }
    assert_true(n > N / 3);
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    duet_point_query *query = open_point_query(tree, 1);
    for (uint32_t i = 0; i < n; ++i) {
        set_poses(tree, &boxes[i], 1);
        duet_point_query_result found = seek_points(query, &points[i], 1);
        long double size, distance = distance_to(&boxes[i], &points[i], 3, &size);
        long double error = fabsl(found.hits[0].distance - distance);
        if (error > 48 * 0x1p-24L * size + 0x1p-61L)
            fail_msg("box %u: %.9g, expected %.9Lg", i, (double)found.hits[0].distance, distance);
        worst = size > 0x1p-30L ? fmaxl(worst, error / size * 0x1p24L) : worst;
    }
    print_message("the worst error is %.2Lf u S, of 48\n", worst);
}

TEST(fewer_boxes_than_asked_for_are_no_error)
{
    const duet_pose box = {{3, 0, 0}, {1, 1, 1}, {0, 0, 0, 1}};
    const duet_point points[2] = {{{0, 0, 0}}, {{NAN, 0, 0}}};
    duet_point_query_result found;
    duet_tree *tree = open_tree(3, 0, &box, 1);
    duet_point_query *query = open_point_query(tree, 2);
    found = seek_points(query, points, 1);
    const duet_point_hit expected[2] = {{0, 0, 2}, {0, DUET_NO_OBJECT, INFINITY}};
    assert_int_equal(found.n_hits, 2);
    assert_memory_equal(found.hits, expected, sizeof expected);
    must_fail(duet_point_query_run(query, points, 2, &found, ERR), DUET_STATUS_BAD_OBJECT,
              "point 1:");
    set_poses(tree, NULL, 0);
    assert_true(seek_points(query, points, 1).hits[0].id == DUET_NO_OBJECT);
}
