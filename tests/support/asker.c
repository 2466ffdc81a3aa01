// SPDX-License-Identifier: MIT
#include "support/asker.h"

#include "support/hits.h"
#include "support/mover.h"
#include "support/test.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"

struct asker {
    duet_tree *tree;
    duet_ray_query *rays, *closest;
    duet_sweep_query *sweeps;
    duet_box_query *boxes;
    duet_point_query *inside, *nearest;
    duet_pose poses[MOVER_MOST]; // poses of the last question's bodies
    uint32_t n;
    uint64_t sum;
};

// ---------------------------------------------------------------- questions

static void fill(rng *r, float *to, uint32_t n, double from, double up_to)
{
    for (uint32_t k = 0; k < n; ++k)
        to[k] = (float)rng_between(r, from, up_to);
}

questions questions_random(rng *r, uint32_t dims, double size)
{
    questions q = {.dims = dims};
    for (uint32_t i = 0; i < ASKED; ++i) {
        fill(r, q.rays[i].origin, dims, -1, size + 1);
        fill(r, q.rays[i].direction, dims, -1, 1);
        q.rays[i].t_max = i % 2 ? INFINITY : (float)rng_between(r, 0, 5);
        fill(r, q.boxes[i].centre, dims, 0, size);
        fill(r, q.boxes[i].half_extents, dims, 0.1, 1);
        fill(r, q.boxes[i].rotation, 4, -1, 1);
        if (dims == 2)
            q.boxes[i].rotation[0] = q.boxes[i].rotation[1] = 0;
        q.sweeps[i] = (duet_sweep){.box = q.boxes[i], .t_max = 2};
        fill(r, q.sweeps[i].direction, dims, -2, 2);
        fill(r, q.points[i].at, dims, 0, size);
    }
    return q;
}

// ---------------------------------------------------------------- queries

asker *asker_open(duet_device_pair *pair, uint32_t dims, uint32_t share)
{
    asker *a = test_alloc(sizeof *a);
    duet_tree_def def = duet_default_tree_def();
    def.pair = pair;
    def.dims = dims;
    def.share = share;
    a->tree = kept(duet_tree_create(&def, ERR));
    a->rays = open_ray_query(a->tree, DUET_QUERY_EVERY, false);
    a->closest = open_ray_query(a->tree, DUET_QUERY_CLOSEST, false);
    a->sweeps = open_sweep_query(a->tree, DUET_QUERY_EVERY);
    a->boxes = open_box_query(a->tree);
    a->inside = open_point_query(a->tree, 0);
    a->nearest = open_point_query(a->tree, ASKED_NEAREST);
    return a;
}

static void add_bytes(asker *a, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        a->sum = (a->sum ^ ((const unsigned char *)bytes)[i]) * UINT64_C(0x100000001b3);
}

static void ask_rays(asker *a, const questions *q, bool twin)
{
    duet_ray_query_result every = cast_rays(a->rays, q->rays, ASKED);
    duet_ray_query_result first = cast_rays(a->closest, q->rays, ASKED);
    add_bytes(a, every.hits, every.n_hits * sizeof *every.hits);
    add_bytes(a, first.hits, first.n_hits * sizeof *first.hits);
    hit_list hits = HITS(every, a->n);
    for (uint32_t i = 0; twin && i < ASKED; ++i) {
        const duet_ray_hit *closest = take_hits(&hits, i);
        if (closest)
            assert_memory_equal(&first.hits[i], closest, sizeof *closest);
        for (uint32_t id = 0; id < a->n; ++id)
            expect_hit(&hits, i, id, ray_meets(&q->rays[i], &a->poses[id], q->dims));
    }
    assert_true(!twin || hits.left == 0);
}

static void ask_sweeps(asker *a, const questions *q, bool twin)
{
    duet_sweep_query_result every = run_sweeps(a->sweeps, DUET_OBJECT_POSES, q->sweeps, ASKED);
    add_bytes(a, every.hits, every.n_hits * sizeof *every.hits);
    hit_list hits = HITS(every, a->n);
    for (uint32_t i = 0; twin && i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            expect_hit(&hits, i, id, sweep_meets(&q->sweeps[i], &a->poses[id], q->dims));
    assert_true(!twin || hits.left == 0);
}

static void ask_boxes(asker *a, const questions *q, bool twin)
{
    duet_box_query_result found = join_boxes(a->boxes, DUET_OBJECT_POSES, q->boxes, ASKED);
    add_bytes(a, found.hits, found.n_hits * sizeof *found.hits);
    hit_list hits = HITS(found, a->n);
    for (uint32_t i = 0; twin && i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            expect_hit(&hits, i, id, narrow_decide(&q->boxes[i], &a->poses[id], q->dims));
    assert_true(!twin || hits.left == 0);
}

static double distance_to(const duet_pose *box, const duet_point *p, uint32_t dims)
{
    double axis[3][3], square = 0, norm = narrow_axes(axis, box->rotation);
    for (uint32_t i = 0; i < dims; ++i) {
        double at = 0;
        for (uint32_t k = 0; k < dims; ++k)
            at += axis[i][k] / norm * ((double)p->at[k] - (double)box->centre[k]);
        double beyond = fmax(fabs(at) - (double)box->half_extents[i], 0);
        square += beyond * beyond;
    }
    return sqrt(square);
}

// How many boxes are nearer, in double.
static uint32_t count_nearer(const asker *a, const duet_point *p, double distance, uint32_t dims)
{
    uint32_t n = 0;
    for (uint32_t id = 0; id < a->n; ++id)
        n += distance_to(&a->poses[id], p, dims) < distance;
    return n;
}

static void ask_points(asker *a, const questions *q, bool twin)
{
    const double bound = 1e-4;
    duet_point_query_result inside = seek_points(a->inside, q->points, ASKED);
    add_bytes(a, inside.hits, inside.n_hits * sizeof *inside.hits);
    hit_list hits = HITS(inside, a->n);
    for (uint32_t i = 0; twin && i < ASKED; ++i) {
        const float *at = q->points[i].at;
        const duet_ray still = {.origin = {at[0], at[1], at[2]}};
        for (uint32_t id = 0; id < a->n; ++id)
            expect_hit(&hits, i, id, ray_meets(&still, &a->poses[id], q->dims));
    }
    assert_true(!twin || hits.left == 0);
    duet_point_query_result near = seek_points(a->nearest, q->points, ASKED);
    add_bytes(a, near.hits, near.n_hits * sizeof *near.hits);
    for (uint64_t k = 0; twin && k < near.n_hits; ++k) {
        const duet_point_hit *hit = &near.hits[k];
        const duet_point *p = &q->points[hit->point];
        uint32_t rank = (uint32_t)(k % ASKED_NEAREST);
        assert_true((hit->id == DUET_NO_OBJECT) == (rank >= a->n));
        if (hit->id == DUET_NO_OBJECT)
            continue;
        double distance = distance_to(&a->poses[hit->id], p, q->dims);
        assert_true(fabs(distance - (double)hit->distance) < bound);
        assert_true(count_nearer(a, p, distance - bound, q->dims) <= rank);
        assert_true(count_nearer(a, p, distance + bound, q->dims) > rank);
    }
}

uint64_t asker_ask(asker *a, duet_motion *motion, const questions *q, bool twin)
{
    a->n = duet_motion_get_count(motion);
    assert_true(a->n <= MOVER_MOST);
    must(duet_motion_get_poses(motion, a->poses, ERR));
    set_poses(a->tree, a->poses, a->n);
    a->sum = UINT64_C(0xcbf29ce484222325);
    ask_rays(a, q, twin);
    ask_sweeps(a, q, twin);
    ask_boxes(a, q, twin);
    ask_points(a, q, twin);
    return a->sum;
}
