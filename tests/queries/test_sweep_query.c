// SPDX-License-Identifier: MIT
// Boxes that move: every hit against a sweep over all boxes in integers, those integers against
// rays and against boxes that stand, and where a hit is said to be against separations in
// double.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/hits.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"

// ---------------------------------------------------------------- worlds

enum { BOXES = 250, SWEEPS = 500 };

typedef struct world {
    duet_pose boxes[BOXES];
    duet_sweep sweeps[SWEEPS];
} world;

// Every third box stands upright on round numbers, every fifth but for a little; some are flat.
static void fill_box(rng *r, uint32_t i, duet_pose *box)
{
    for (int k = 0; k < 4; ++k) {
        box->rotation[k] = k == 3;
        if (i % 3 != 0)
            box->rotation[k] += (float)rng_normal(r) * (i % 5 == 0 ? 1e-5f : 1);
        if (k == 3)
            break;
        box->centre[k] = (float)rng_between(r, -4, 4);
        box->half_extents[k] = i % 17 == 0 && k == 1 ? 0 : (float)rng_between(r, 0.05, 0.5);
        if (i % 3 == 0) {
            box->centre[k] = roundf(box->centre[k]);
            box->half_extents[k] = 0.5f;
        }
    }
}

static world *make_world(void)
{
    world *w = test_alloc(sizeof *w);
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < BOXES; ++i)
        fill_box(&r, i, &w->boxes[i]);
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        duet_sweep *s = &w->sweeps[i];
        fill_box(&r, i, &s->box);
        for (int k = 0; k < 3; ++k)
            s->direction[k] = i % 6 == 0 ? (k == (int)(i % 4)) : (float)rng_between(&r, -3, 3);
        s->t_max = i % 7 == 0 ? INFINITY : i % 6 == 0 ? (float)rng_below(&r, 4) : 1;
    }
    return w;
}

// ---------------------------------------------------------------- truth of the truth

TEST(integers_agree_with_rays_and_with_boxes_that_stand)
{
    rng r = rng_seed(test_seed());
    world *w = make_world();
    uint32_t n_met = 0;
    for (uint32_t i = 0; i < SWEEPS; ++i)
        for (uint32_t dims = 2; dims <= 3; ++dims) {
            const duet_pose *box = &w->boxes[rng_below(&r, BOXES)];
            duet_sweep point = w->sweeps[i], still = w->sweeps[i];
            duet_ray ray = {.t_max = point.t_max};
            memset(point.box.half_extents, 0, sizeof point.box.half_extents);
            memset(still.direction, 0, sizeof still.direction);
            for (int k = 0; k < 3; ++k)
                point.direction[k] = box->centre[k] - point.box.centre[k] +
                                     (float)((int)rng_below(&r, 3) - 1) * box->half_extents[k];
            memcpy(ray.origin, point.box.centre, sizeof ray.origin);
            memcpy(ray.direction, point.direction, sizeof ray.direction);
            bool met = ray_meets_exactly(&ray, box, dims);
            assert_int_equal(sweep_meets_exactly(&point, box, dims), met);
            assert_int_equal(sweep_meets(&point, box, dims), met);
            still.box.centre[0] = box->centre[0] + 0.5f;
            still.box.centre[1] = box->centre[1];
            assert_int_equal(sweep_meets_exactly(&still, box, dims),
                             narrow_exact(&still.box, box, dims));
            n_met += met;
        }
    assert_true(n_met > SWEEPS / 4);
}

// Hard pairs that are pushed apart and back: the way has t = 1 on it, where they stand.
TEST(double_agrees_with_integers_on_hard_pairs)
{
    rng r = rng_seed(test_seed());
    uint32_t n_classes = 0, n_met = 0;
    while (hard_classes[n_classes].name)
        ++n_classes;
    for (uint32_t i = 0; i < 3000; ++i) {
        hard_pair pair = hard_classes[i % n_classes].make(&r, 3);
        duet_sweep sweep = {.box = pair.a, .t_max = i % 2 ? 1 : 2};
        bool usual = narrow_is_box(&pair.a, 3) && narrow_is_box(&pair.b, 3);
        for (int k = 0; k < 3; ++k) {
            float size = pair.a.half_extents[k] + pair.b.half_extents[k];
            sweep.direction[k] = (float)((int)rng_below(&r, 5) - 2) * size;
            sweep.box.centre[k] -= sweep.direction[k];
            usual = usual && fabsf(sweep.box.centre[k]) < 0x1p100f && size < 0x1p90f &&
                    (sweep.direction[k] == 0 || fabsf(sweep.direction[k]) > 0x1p-90f);
        }
        if (!usual)
            continue;
        bool met = sweep_meets_exactly(&sweep, &pair.b, 3);
        n_met += met;
        assert_int_equal(sweep_meets(&sweep, &pair.b, 3), met);
    }
    assert_true(n_met > 500);
}

// ---------------------------------------------------------------- hits

static long double size_of(const duet_sweep *s, const duet_pose *box)
{
    long double size = 0;
    for (int k = 0; k < 3; ++k)
        size += fabsl((long double)s->box.centre[k] - box->centre[k]) + s->box.half_extents[k] +
                box->half_extents[k];
    return size;
}

static double separation_at(const duet_sweep *s, const duet_pose *box, double t, uint32_t dims)
{
    const double shift[3] = {t * s->direction[0], t * s->direction[1],
                             dims == 3 ? t * s->direction[2] : 0};
    return narrow_widest_separation(box, &s->box, shift, dims);
}

// They touch at t, not before, and the normal points from one to the other.
static void check_hit(const duet_sweep *s, const duet_pose *box, const duet_sweep_hit *hit,
                      uint32_t dims)
{
    double error = 0x1p-22 * (double)size_of(s, box);
    double at = separation_at(s, box, hit->t, dims), length = 0, toward = 0;
    assert_true(hit->t >= 0 && hit->t <= s->t_max);
    if (at > error || (hit->t > 0 && at < -error))
        fail_msg("at t %.9g the boxes are %.3g apart, expected 0 within %.3g", (double)hit->t, at,
                 error);
    for (int k = 0; k < 3; ++k) {
        length += (double)hit->normal[k] * hit->normal[k];
        toward += (double)hit->normal[k] * s->direction[k];
    }
    assert_true(hit->t == 0 || (fabs(length - 1) < 1e-6 && toward < 0));
    for (int i = 1; i < 8; ++i)
        assert_true(hit->t == 0 || separation_at(s, box, hit->t * i / 8, dims) > -error);
}

static void every_hit_in(uint32_t dims, uint32_t share)
{
    world *w = make_world();
    duet_tree *tree = open_tree(dims, share, w->boxes, BOXES);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_POSES, w->sweeps, SWEEPS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < SWEEPS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id, sweep_meets_exactly(&w->sweeps[i], &w->boxes[id], dims));
    expect_no_more(&hits, SWEEPS / 4);
    for (const duet_sweep_hit *hit = found.hits; hit < found.hits + found.n_hits; ++hit)
        check_hit(&w->sweeps[hit->sweep], &w->boxes[hit->id], hit, dims);
    print_message("%uD: %" PRIu64 " hits, %" PRIu64 " undecided\n", dims, found.n_hits,
                  found.undecided);
    assert_true(found.undecided < found.n_hits);
}

TEST(every_hit_is_found_and_no_other)
{
    every_hit_in(3, DUET_SHARE_ONE / 3);
    every_hit_in(2, DUET_SHARE_ONE);
}

TEST(closest_and_any_are_of_every_hit)
{
    world *w = make_world();
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 2, w->boxes, BOXES);
    duet_tree *other = open_tree(3, 0, w->boxes, BOXES);
    closest_and_any_are_of_every(tree, other, DUET_OBJECT_POSES, w->sweeps, SWEEPS, BOXES);
}

// ---------------------------------------------------------------- bounds

static void moving_bounds_are_exact_in(uint32_t dims)
{
    enum { N = 300 };
    static duet_bounds boxes[N];
    static duet_bounds_sweep sweeps[N];
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) {
            float round = i % 2 ? 1.0f : 0.3f;
            boxes[i].lower[k] = round * (float)rng_below(&r, 12);
            boxes[i].upper[k] = boxes[i].lower[k] + round * (float)rng_below(&r, 3);
            sweeps[i].bounds = boxes[(i * 7) % (i + 1)];
            sweeps[i].direction[k] = (float)rng_below(&r, 5) - 2;
            sweeps[i].t_max = i % 5 ? 2 : INFINITY;
        }
    duet_tree *tree = open_bounds_tree(dims, DUET_SHARE_ONE / 3, boxes, N);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_BOUNDS, sweeps, N);
    hit_list hits = HITS(found, N);
    for (uint32_t i = 0; i < N; ++i)
        for (uint32_t id = 0; id < N; ++id)
            expect_hit(&hits, i, id, sweep_meets_bounds(&sweeps[i], &boxes[id], dims));
    expect_no_more(&hits, N);
    for (const duet_sweep_hit *hit = found.hits; hit < found.hits + found.n_hits; ++hit) {
        const duet_bounds_sweep *s = &sweeps[hit->sweep];
        const duet_bounds *box = &boxes[hit->id];
        long double enter = 0;
        for (uint32_t k = 0; k < dims; ++k) {
            float speed = s->direction[k];
            long double gap = speed > 0 ? (long double)box->lower[k] - s->bounds.upper[k]
                                        : (long double)box->upper[k] - s->bounds.lower[k];
            enter = speed != 0 ? fmaxl(enter, gap / speed) : enter;
        }
        assert_true(fabsl(hit->t - enter) <= 0x1p-23L * enter);
    }
}

TEST(moving_bounds_are_exact)
{
    moving_bounds_are_exact_in(3);
    moving_bounds_are_exact_in(2);
}

// ---------------------------------------------------------------- closed forms

TEST(a_cube_stops_at_a_wall)
{
    const duet_pose wall = {{5, 0, 0}, {1, 9, 9}, {0, 0, 0, 1}};
    const duet_pose cube = {{0, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    const duet_sweep sweeps[] = {
        {cube, {1, 0, 0}, INFINITY},
        {cube, {7, 0, 0}, 0.5f},                                           // ends as it touches
        {cube, {7, 0, 0}, 0.49999997f},                                    // one float short of it
        {cube, {0, 1, 0}, INFINITY},                                       // beside it
        {{{4, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}}, {-1, 0, 0}, 1},    // begins inside
        {{{3.5f, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}}, {-1, 0, 0}, 1}, // begins as it touches
        {{{0, 0, 0}, {0.5f, 0.5f, 0.5f}, {0, 0, 0.38268343f, 0.92387953f}}, {1, 0, 0}, INFINITY}};
    enum { N = sizeof sweeps / sizeof *sweeps };
    const duet_sweep_hit expected[] = {{0, 0, 3.5f, {-1, 0, 0}},
                                       {1, 0, 0.5f, {-1, 0, 0}},
                                       {2, DUET_NO_OBJECT, INFINITY, {0}},
                                       {3, DUET_NO_OBJECT, INFINITY, {0}},
                                       {4, 0, 0, {0}},
                                       {5, 0, 0, {0}}};
    duet_tree *tree = open_tree(3, 0, &wall, 1);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_POSES, sweeps, N);
    assert_int_equal(found.n_hits, N);
    for (int i = 0; i < N - 1; ++i)
        for (int k = 0; k < 3; ++k)
            assert_true(found.hits[i].id == expected[i].id && found.hits[i].t == expected[i].t &&
                        found.hits[i].normal[k] == expected[i].normal[k]);
    assert_true(fabsf(found.hits[N - 1].t - (4 - sqrtf(0.5f))) < 1e-6f); // edge first
}

// Turned boxes that touch exactly: where they do is rounded, and yet no way is left.
TEST(what_touches_at_the_begin_has_no_normal)
{
    const duet_pose box = {{1, 2, 2}, {4, 2, 3}, {1, 1, 1, 1}};
    const duet_pose mover = {{4, -2, 0}, {0, 2, 4}, {3, 1, -2, 5}};
    const duet_sweep sweeps[] = {{mover, {0, 0, 2}, 0},
                                 {mover, {0, 0, 2}, 1},
                                 {mover, {0, 0, -2}, 1},
                                 {mover, {0, 0, 0}, 1}};
    enum { N = sizeof sweeps / sizeof *sweeps };
    assert_true(narrow_exact(&mover, &box, 3));
    duet_tree *tree = open_tree(3, 0, &box, 1);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
    const duet_sweep_hit *hits = run_sweeps(query, DUET_OBJECT_POSES, sweeps, N).hits;
    for (int i = 0; i < N; ++i) {
        assert_true(hits[i].id == 0 && hits[i].t == 0);
        assert_true(hits[i].normal[0] == 0 && hits[i].normal[1] == 0 && hits[i].normal[2] == 0);
    }
}

TEST(what_is_no_sweep_is_refused_by_its_number)
{
    const duet_pose box = {{0}, {1, 1, 1}, {0, 0, 0, 1}};
    duet_tree *tree = open_tree(3, 0, &box, 1);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
    const duet_sweep good = {box, {1, 0, 0}, 1};
    duet_sweep bad[] = {good, good, good, good};
    bad[0].box.half_extents[2] = -1;
    bad[1].direction[0] = NAN;
    bad[2].t_max = -1;
    bad[3].direction[0] = 1e-35f;
    for (int i = 0; i < 4; ++i) {
        duet_sweep_query_result found;
        const duet_sweep sweeps[3] = {good, good, bad[i]};
        must_fail(duet_sweep_query_run(query, DUET_OBJECT_POSES, sweeps, 3, &found, ERR),
                  DUET_STATUS_BAD_OBJECT, "sweep 2:");
    }
}
