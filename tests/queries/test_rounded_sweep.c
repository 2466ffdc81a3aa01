// SPDX-License-Identifier: MIT
// Rounded boxes that move: integers against closed forms, and against the least distance by a
// search in time; every hit against integers, and where it is against the reference's separation.
#include "support/test.h"

#include "support/devices.h"
#include "support/hits.h"
#include "support/trees.h"

#include "runtime/narrowphase/rounded.h"
#include "runtime/queries/rounded_sweep.h"

enum { BOXES = 160, SWEEPS = 240 };

typedef struct world {
    duet_rounded_box boxes[BOXES];
    duet_rounded_sweep sweeps[SWEEPS];
} world;

static world *make_world(void)
{
    world *w = test_alloc(sizeof *w);
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < BOXES; ++i)
        w->boxes[i] = draw_rounded(&r, i);
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        duet_rounded_sweep *s = &w->sweeps[i];
        s->box = draw_rounded(&r, 5 * i + i / 4);
        for (int k = 0; k < 3; ++k)
            s->direction[k] = i % 4 == 0 ? (k == (int)(i / 4 % 4)) : (float)rng_between(&r, -3, 3);
        s->t_max = i % 7 == 0 ? INFINITY : i % 4 == 0 ? (float)rng_below(&r, 4) : 1;
        if (i % 4 == 0 && i % 3 == 0)
            memcpy(s->box.pose.rotation, (float[4]){0, 0, 0, 1}, sizeof s->box.pose.rotation);
    }
    return w;
}

// ---------------------------------------------------------------- truth of the truth

static double separation_at(const duet_rounded_sweep *s, const duet_rounded_box *box, double t,
                            uint32_t dims)
{
    duet_rounded_box moved = s->box;
    for (int k = 0; k < 3; ++k)
        moved.pose.centre[k] = (float)(s->box.pose.centre[k] + t * s->direction[k]);
    return duet_rounded_boxes_separation(&moved, box, dims);
}

// By thirds, since the distance is convex; once the two overlap it no longer counts.
static double least_separation(const duet_rounded_sweep *s, const duet_rounded_box *box,
                               uint32_t dims)
{
    double from = 0, to = s->t_max, length = 0, least = INFINITY;
    for (uint32_t k = 0; k < dims; ++k)
        length += (double)s->direction[k] * s->direction[k];
    to = length > 0 ? fmin(to, 40 / sqrt(length)) : 0;
    for (int step = 0; step < 60 && least > 0; ++step) {
        double a = from + (to - from) / 3, b = to - (to - from) / 3;
        double at_a = separation_at(s, box, a, dims), at_b = separation_at(s, box, b, dims);
        least = fmin(least, fmin(at_a, at_b));
        if (at_a <= at_b)
            to = b;
        else
            from = a;
    }
    return fmin(least, fmin(separation_at(s, box, from, dims), separation_at(s, box, to, dims)));
}

TEST(integers_agree_with_a_search_in_time)
{
    world *w = make_world();
    uint32_t met = 0, told = 0;
    for (uint32_t i = 0; i < SWEEPS; ++i)
        for (uint32_t id = i % 40; id < BOXES; id += 40) {
            uint32_t dims = 2 + (i + id) % 2;
            const duet_rounded_sweep *s = &w->sweeps[i];
            bool is_met = rounded_sweep_meets_exactly(s, &w->boxes[id], dims);
            double least = least_separation(s, &w->boxes[id], dims);
            assert_int_equal(rounded_sweep_meets(s, &w->boxes[id], dims), is_met);
            if (fabs(least) > 2e-5 && is_met != (least < 0))
                fail_msg("sweep %u and box %u in %uD: %s, %.3g apart", i, id, dims,
                         is_met ? "meets" : "misses", least);
            met += is_met;
            told += fabs(least) > 2e-5;
        }
    assert_true(met > SWEEPS / 8 && told > SWEEPS);
}

typedef struct known {
    const char *name;
    duet_rounded_box moving;
    float direction[3], t_max;
    duet_rounded_box still;
    float t; // time of the first touch; < 0: none
    float normal[3];
} known;

#define KNOWN(grazes, ...)    \
    {                         \
        {__VA_ARGS__}, grazes \
    }

// Each one touches, exactly; with a radius an ulp smaller it does not where `grazes`.
static const struct {
    known k;
    bool grazes;
} closed[] = {
    // Spheres: head on, at an angle of 3 4 5, and past each other.
    KNOWN(false, "sphere to sphere", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 1}, {1, 0, 0}, INFINITY,
          {{{10, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, 7, {-1, 0, 0}),
    KNOWN(false, "sphere aside", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, {0.5f, 0, 0}, INFINITY,
          {{{10, 4, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 3}, 14, {-0.6f, -0.8f, 0}),
    KNOWN(true, "sphere past", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, {0.5f, 0, 0}, INFINITY,
          {{{10, 5, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 3}, 20, {0, -1, 0}),
    KNOWN(true, "sphere past a lattice way", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 1}, {4, 3, 0},
          8, {{{15, 15, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, 4.2f, {0.6f, -0.8f, 0}),
    // Spheres and a box's face, edge (3 4 5) and corner (1 2 2).
    KNOWN(true, "sphere to face", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 1}, {0, 0, 2}, 3,
          {{{0.5f, 0.25f, 8}, {1, 1, 1}, {0, 0, 0, 1}}, 0}, 3, {0, 0, -1}),
    KNOWN(true, "sphere along a face", {{{-9, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 1}, {1, 0, 0},
          INFINITY, {{{0, 0, 3}, {1, 1, 1.5f}, {0, 0, 0, 1}}, 0.5f}, 8, {0, 0, -1}),
    KNOWN(false, "sphere to edge", {{{-9, 4, 0.5f}, {0, 0, 0}, {0, 0, 0, 1}}, 4}, {1, 0, 0},
          INFINITY, {{{1, -1, 0}, {1, 1, 1}, {0, 0, 0, 1}}, 1}, 6, {-0.6f, 0.8f, 0}),
    KNOWN(false, "sphere to corner", {{{-9, 2, 2}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, {2, 0, 0},
          INFINITY, {{{1, -1, -1}, {1, 1, 1}, {0, 0, 0, 1}}, 1}, 4,
          {-1.0f / 3, 2.0f / 3, 2.0f / 3}),
    KNOWN(true, "sphere past a corner", {{{-9, 3, 4}, {0, 0, 0}, {0, 0, 0, 1}}, 4}, {1, 0, 0},
          INFINITY, {{{0, -1, -1}, {0, 1, 1}, {0, 0, 0, 1}}, 1}, 9, {0, 0.6f, 0.8f}),
    // Capsules: across each other, side by side, end to end, and one that passes.
    KNOWN(false, "capsules across", {{{0, 0, 0}, {3, 0, 0}, {0, 0, 0, 1}}, 0.5f}, {0, 1, 0},
          INFINITY, {{{1, 6, 2}, {0, 0, 3}, {0, 0, 0, 1}}, 0.25f}, 5.25f, {0, -1, 0}),
    KNOWN(true, "capsules past", {{{0, 0, 0}, {3, 0, 0}, {0, 0, 0, 1}}, 0.5f}, {0, 1, 0}, INFINITY,
          {{{0, 6, 0.75f}, {3, 0, 0}, {0, 0, 0, 1}}, 0.25f}, 6, {0, 0, -1}),
    KNOWN(false, "capsules in line", {{{0, 0, 0}, {2, 0, 0}, {0, 0, 0, 1}}, 0.5f}, {1, 0, 0}, 10,
          {{{10, 0, 0}, {2, 0, 0}, {0, 0, 0, 1}}, 0.5f}, 5, {-1, 0, 0}),
    KNOWN(true, "capsule ends as it touches", {{{0, 0, 0}, {2, 0, 0}, {0, 0, 0, 1}}, 0.5f},
          {1, 0, 0}, 5, {{{10, 0, 0}, {2, 0, 0}, {0, 0, 0, 1}}, 0.5f}, 5, {-1, 0, 0}),
    // A cube turned about x by 3 4 5 (2 1 as quaternion), whose edge leads; radius against radius.
    KNOWN(false, "turned cube", {{{0, 0, 0}, {1, 5, 5}, {1, 0, 0, 2}}, 0.5f}, {0, 0, 1}, INFINITY,
          {{{0, 0, 20}, {4, 4, 1}, {0, 0, 0, 1}}, 0.5f}, 11, {0, 0, -1}),
    KNOWN(true, "begins as it touches", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, {-1, 0, 0}, 1,
          {{{3, 4, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 3}, 0, {0, 0, 0}),
    KNOWN(true, "stays where it touches", {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 2}, {0, 0, 0},
          INFINITY, {{{3, 4, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 3}, 0, {0, 0, 0}),
};

enum { CLOSED = sizeof closed / sizeof *closed };

static duet_rounded_sweep sweep_of(const known *k)
{
    return (duet_rounded_sweep){
        k->moving, {k->direction[0], k->direction[1], k->direction[2]}, k->t_max};
}

TEST(touching_is_meeting_and_an_ulp_less_is_not)
{
    for (int i = 0; i < CLOSED; ++i) {
        const known *k = &closed[i].k;
        duet_rounded_sweep s = sweep_of(k);
        float normal[3], t = rounded_sweep_enter(&s, &k->still, 3, normal);
        if (!rounded_sweep_meets_exactly(&s, &k->still, 3) ||
            !rounded_sweep_meets(&s, &k->still, 3))
            fail_msg("%s: misses", k->name);
        if (fabsf(t - k->t) > 4e-6f * (1 + k->t))
            fail_msg("%s: touches at %.9g, expected %.9g", k->name, (double)t, (double)k->t);
        for (int n = 0; n < 3 && !closed[i].grazes; ++n)
            if (fabsf(normal[n] - k->normal[n]) > 1e-6f)
                fail_msg("%s: normal %g %g %g", k->name, (double)normal[0], (double)normal[1],
                         (double)normal[2]);
        s.box.radius = nextafterf(s.box.radius, 0);
        bool less = rounded_sweep_meets_exactly(&s, &k->still, 3);
        if (less == closed[i].grazes || rounded_sweep_meets(&s, &k->still, 3) != less)
            fail_msg("%s: with a radius an ulp less it %s", k->name, less ? "meets" : "misses");
    }
}

// Cores that miss each other by less than double sees, and radii that are no greater.
TEST(radii_that_vanish_leave_a_normal)
{
    const known cases[] = {
        {"edges that end at one height",
         {{{3, -1, -0x1p-149f}, {0, 0, 1e6f}, {0, 0, 1, 1}}, 0x1p-149f},
         {-1, 1, 0},
         INFINITY,
         {{{0x1p-140f, -1e-6f, 1e6f}, {1e6f, 0, 0}, {0, 0, 1, 1}}, 0x1p-140f},
         3,
         {1, 0, 0}},
        {"a point beside a long box",
         {{{-0x1p20f, 1, 0}, {0x1p20f, 0, 1}, {0, 0, 0, 1}}, 0x1p-64f},
         {0, -1, 0},
         1,
         {{{0x1p-149f, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}, 0},
         1,
         {0, 1, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        float normal[3];
        duet_rounded_sweep s = sweep_of(&cases[i]);
        assert_true(rounded_sweep_meets_exactly(&s, &cases[i].still, 3));
        float t = rounded_sweep_enter(&s, &cases[i].still, 3, normal);
        double along = 0;
        for (int k = 0; k < 3; ++k)
            along += (double)normal[k] * cases[i].normal[k];
        if (!(fabsf(t - cases[i].t) <= 0.25f && fabs(along - 1) < 1e-6))
            fail_msg("%s: t %g, normal %g %g %g", cases[i].name, (double)t, (double)normal[0],
                     (double)normal[1], (double)normal[2]);
    }
}

// ---------------------------------------------------------------- hits

// The bound of docs/accuracy.md, and what rounding a centre adds that moved.
static double error_of(const duet_rounded_sweep *s, const duet_rounded_box *box)
{
    double size = (double)s->box.radius + box->radius, far = 0;
    for (int k = 0; k < 3; ++k) {
        size += fabs((double)s->box.pose.centre[k] - box->pose.centre[k]) +
                s->box.pose.half_extents[k] + box->pose.half_extents[k];
        far += fabs(s->box.pose.centre[k]);
    }
    return 0x1p-22 * size + 0x1p-24 * (far + 2 * size);
}

// They touch at t, not before, and the normal points from one to the other.
static void check_hit(const duet_rounded_sweep *s, const duet_rounded_box *box,
                      const duet_sweep_hit *hit, uint32_t dims)
{
    double error = error_of(s, box), length = 0, toward = 0;
    double at = separation_at(s, box, hit->t, dims);
    assert_true(hit->t >= 0 && hit->t <= s->t_max);
    if (at > error || (hit->t > 0 && at < -error))
        fail_msg("sweep %u, box %u: at t %.9g they are %.3g apart, expected 0 within %.3g",
                 hit->sweep, hit->id, (double)hit->t, at, error);
    for (int k = 0; k < 3; ++k) {
        length += (double)hit->normal[k] * hit->normal[k];
        toward += (double)hit->normal[k] * s->direction[k];
    }
    assert_true(hit->t == 0 || (fabs(length - 1) < 1e-6 && toward < 1e-5));
    for (int i = 1; i < 8; ++i)
        assert_true(hit->t == 0 || separation_at(s, box, hit->t * i / 8, dims) > -error);
}

static void every_hit_in(uint32_t dims, uint32_t share)
{
    world *w = make_world();
    duet_tree *tree = open_rounded_tree(dims, share, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_ROUNDED_BOXES, w->sweeps, SWEEPS);
    hit_list hits = HITS(found, BOXES);
    for (uint32_t i = 0; i < SWEEPS; ++i)
        for (uint32_t id = 0; id < BOXES; ++id)
            expect_hit(&hits, i, id, rounded_sweep_meets(&w->sweeps[i], &w->boxes[id], dims));
    expect_no_more(&hits, SWEEPS / 4);
    for (const duet_sweep_hit *hit = found.hits; hit < found.hits + found.n_hits; ++hit)
        check_hit(&w->sweeps[hit->sweep], &w->boxes[hit->id], hit, dims);
    print_message("%uD: %" PRIu64 " hits, %" PRIu64 " undecided\n", dims, found.n_hits,
                  found.undecided);
    assert_true(4 * found.undecided < found.n_hits);
}

TEST(every_hit_is_found_and_no_other)
{
    every_hit_in(3, DUET_SHARE_ONE / 3);
    every_hit_in(2, DUET_SHARE_ONE);
    devices_seem_gpus(true);
    every_hit_in(3, 0);
    devices_seem_gpus(false);
}

// A box that only just touches is none of float's business.
TEST(closed_forms_hold_on_devices)
{
    for (int i = 0; i < CLOSED; ++i) {
        const known *k = &closed[i].k;
        duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, &k->still, 1);
        duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
        duet_rounded_sweep sweeps[2] = {sweep_of(k), sweep_of(k)};
        sweeps[1].box.radius = nextafterf(sweeps[1].box.radius, 0);
        duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_ROUNDED_BOXES, sweeps, 2);
        assert_int_equal(found.n_hits, closed[i].grazes ? 1 : 2);
        assert_true(fabsf(found.hits[0].t - k->t) <= 4e-6f * (1 + k->t));
    }
}

TEST(closest_and_any_are_of_every_hit)
{
    world *w = make_world();
    duet_tree *tree =
        open_rounded_tree(3, DUET_SHARE_ONE / 2, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
    duet_tree *other = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
    closest_and_any_are_of_every(tree, other, DUET_OBJECT_ROUNDED_BOXES, w->sweeps, SWEEPS, BOXES);
}

// A body that moves among rounded boxes has the hits of any other form of both, by another share.
static void assert_same_hits(const world *w, duet_tree *tree, duet_object_kind kind,
                             const void *sweeps)
{
    duet_tree *rounded = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
    duet_sweep_query_result a = run_sweeps(open_sweep_query(rounded, DUET_QUERY_EVERY),
                                           DUET_OBJECT_ROUNDED_BOXES, w->sweeps, SWEEPS);
    duet_sweep_query_result b =
        run_sweeps(open_sweep_query(tree, DUET_QUERY_EVERY), kind, sweeps, SWEEPS);
    assert_true(a.n_hits == b.n_hits && a.n_hits > SWEEPS / 8);
    assert_memory_equal(a.hits, b.hits, a.n_hits * sizeof *a.hits);
}

TEST(boxes_without_radii_have_the_hits_of_poses)
{
    world *w = make_world();
    duet_pose poses[BOXES];
    duet_sweep sweeps[SWEEPS];
    for (uint32_t i = 0; i < BOXES; ++i) {
        w->boxes[i].radius = 0;
        poses[i] = w->boxes[i].pose;
    }
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        duet_rounded_sweep *s = &w->sweeps[i];
        s->box.radius = 0;
        sweeps[i] = (duet_sweep){.box = s->box.pose, .t_max = s->t_max};
        memcpy(sweeps[i].direction, s->direction, sizeof s->direction);
    }
    assert_same_hits(w, open_tree(3, DUET_SHARE_ONE / 3, poses, BOXES), DUET_OBJECT_POSES, sweeps);
}

static void scale_box(duet_rounded_box *box, float scale)
{
    box->radius *= scale;
    for (int k = 0; k < 3; ++k) {
        box->pose.centre[k] *= scale;
        box->pose.half_extents[k] *= scale;
    }
}

// Squares of such lengths are no floats.
TEST(lengths_of_any_scale_have_the_same_hits)
{
    const float scales[] = {1, 0x1p75f, 0x1p-60f};
    duet_sweep_hit *first = NULL;
    uint64_t n = 0;
    for (int i = 0; i < 3; ++i) {
        world *w = make_world();
        for (uint32_t id = 0; id < BOXES; ++id)
            scale_box(&w->boxes[id], scales[i]);
        for (uint32_t s = 0; s < SWEEPS; ++s) {
            scale_box(&w->sweeps[s].box, scales[i]);
            for (int k = 0; k < 3; ++k)
                w->sweeps[s].direction[k] *= scales[i];
        }
        duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, w->boxes, BOXES);
        duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
        duet_sweep_query_result found =
            run_sweeps(query, DUET_OBJECT_ROUNDED_BOXES, w->sweeps, SWEEPS);
        if (i == 0) {
            n = found.n_hits;
            first = test_alloc((size_t)n * sizeof *first);
            memcpy(first, found.hits, (size_t)n * sizeof *first);
        }
        assert_int_equal(found.n_hits, n);
        assert_memory_equal(found.hits, first, (size_t)n * sizeof *first);
    }
}

TEST(spheres_move_as_rounded_boxes)
{
    world *w = make_world();
    duet_sphere spheres[BOXES];
    duet_sphere_sweep sweeps[SWEEPS];
    for (uint32_t i = 0; i < BOXES; ++i) {
        memcpy(spheres[i].centre, w->boxes[i].pose.centre, sizeof spheres[i].centre);
        spheres[i].radius = w->boxes[i].radius;
        w->boxes[i] = rounded_of_sphere(&spheres[i]);
    }
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        duet_rounded_sweep *s = &w->sweeps[i];
        sweeps[i] = (duet_sphere_sweep){.sphere.radius = s->box.radius, .t_max = s->t_max};
        memcpy(sweeps[i].sphere.centre, s->box.pose.centre, sizeof sweeps[i].sphere.centre);
        memcpy(sweeps[i].direction, s->direction, sizeof s->direction);
        s->box = rounded_of_sphere(&sweeps[i].sphere);
    }
    duet_tree *round =
        open_rounded_tree(3, DUET_SHARE_ONE / 3, DUET_OBJECT_SPHERES, spheres, BOXES);
    assert_same_hits(w, round, DUET_OBJECT_SPHERES, sweeps);
}

// ---------------------------------------------------------------- refusals

TEST(what_is_no_sweep_of_the_shape_is_refused)
{
    const duet_rounded_box box = rounded_at(0, 0, 0, 1, 1, 1, 1);
    duet_rounded_sweep sweeps[2] = {{box, {1, 0, 0}, 1}, {box, {1, 0, 0}, 1}};
    duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, &box, 1);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_EVERY);
    duet_sweep_query_result found;
    const float wrong[] = {-1, NAN, INFINITY, 0x1p101f};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        sweeps[1].box.radius = wrong[i];
        must_fail(duet_sweep_query_run(query, DUET_OBJECT_ROUNDED_BOXES, sweeps, 2, &found, ERR),
                  DUET_STATUS_BAD_OBJECT, "sweep 1: ");
    }
    must_fail(duet_sweep_query_run(query, DUET_OBJECT_POSES, sweeps, 2, &found, ERR),
              DUET_STATUS_BAD_ARGUMENT, "the tree is of rounded boxes");
}
