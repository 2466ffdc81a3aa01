// SPDX-License-Identifier: MIT
#include "support/asker.h"

#include "support/test.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"

struct asker {
    duet_tree *tree;
    duet_ray_query *rays, *closest;
    duet_sweep_query *sweeps;
    duet_box_query *boxes;
    duet_point_query *inside, *nearest;
    duet_pose *poses; // poses of the last question's bodies
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

// Opens a query of the tree with a member of its def set.
#define OPEN(a, at, kind, member, value)                           \
    do {                                                           \
        duet_error why = {0};                                      \
        duet_##kind##_def of = duet_default_##kind##_def();        \
        of.tree = (a)->tree;                                       \
        of.member = value;                                         \
        assert_ok((a)->at = duet_##kind##_create(&of, &why), why); \
    } while (0)

asker *asker_open(duet_device_pair *pair, uint32_t dims, uint32_t share)
{
    asker *a = calloc(1, sizeof *a);
    duet_tree_def def = duet_default_tree_def();
    def.pair = pair;
    def.dims = dims;
    def.share = share;
    a->tree = must(duet_tree_create(&def, ERR));
    OPEN(a, rays, ray_query, wants, DUET_QUERY_EVERY);
    OPEN(a, closest, ray_query, wants, DUET_QUERY_CLOSEST);
    OPEN(a, sweeps, sweep_query, wants, DUET_QUERY_EVERY);
    OPEN(a, boxes, box_query, level, DUET_LEVEL_CERTIFIED);
    OPEN(a, inside, point_query, nearest, 0);
    OPEN(a, nearest, point_query, nearest, ASKED_NEAREST);
    return a;
}

void asker_close(asker *a)
{
    if (!a)
        return;
    duet_ray_query_destroy(a->rays);
    duet_ray_query_destroy(a->closest);
    duet_sweep_query_destroy(a->sweeps);
    duet_box_query_destroy(a->boxes);
    duet_point_query_destroy(a->inside);
    duet_point_query_destroy(a->nearest);
    duet_tree_destroy(a->tree);
    free(a->poses);
    free(a);
}

static void add_bytes(asker *a, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        a->sum = (a->sum ^ ((const unsigned char *)bytes)[i]) * UINT64_C(0x100000001b3);
}

// Which objects an item meets, as the query says it and as the twin does.
typedef struct verdicts {
    uint8_t *found, *right; // [ASKED][n]
} verdicts;

static verdicts make_verdicts(const asker *a)
{
    size_t n = (size_t)ASKED * a->n + 1;
    return (verdicts){calloc(n, 1), calloc(n, 1)};
}

static void assert_right(const asker *a, verdicts v, const char *kind)
{
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            if (v.found[i * a->n + id] != v.right[i * a->n + id])
                fail_msg("%s %u and body %u: %d, and %d by the twin", kind, i, id,
                         v.found[i * a->n + id], v.right[i * a->n + id]);
    free(v.found);
    free(v.right);
}

static void ask_rays(asker *a, const questions *q, bool twin)
{
    duet_ray_query_result every, first;
    must(duet_ray_query_run(a->rays, q->rays, ASKED, &every, ERR));
    must(duet_ray_query_run(a->closest, q->rays, ASKED, &first, ERR));
    add_bytes(a, every.hits, every.n_hits * sizeof *every.hits);
    add_bytes(a, first.hits, first.n_hits * sizeof *first.hits);
    if (!twin)
        return;
    verdicts v = make_verdicts(a);
    for (uint64_t k = every.n_hits; k-- > 0;) { // the first of a ray is its closest
        const duet_ray_hit *hit = &every.hits[k];
        ++v.found[hit->ray * a->n + hit->id];
        if (k == 0 || every.hits[k - 1].ray != hit->ray)
            assert_memory_equal(&first.hits[hit->ray], hit, sizeof *hit);
    }
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            v.right[i * a->n + id] = ray_meets(&q->rays[i], &a->poses[id], q->dims);
    assert_right(a, v, "ray");
}

static void ask_sweeps(asker *a, const questions *q, bool twin)
{
    duet_sweep_query_result every;
    must(duet_sweep_query_run(a->sweeps, DUET_OBJECT_POSES, q->sweeps, ASKED, &every, ERR));
    add_bytes(a, every.hits, every.n_hits * sizeof *every.hits);
    if (!twin)
        return;
    verdicts v = make_verdicts(a);
    for (uint64_t k = 0; k < every.n_hits; ++k)
        ++v.found[every.hits[k].sweep * a->n + every.hits[k].id];
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            v.right[i * a->n + id] = sweep_meets(&q->sweeps[i], &a->poses[id], q->dims);
    assert_right(a, v, "sweep");
}

static void ask_boxes(asker *a, const questions *q, bool twin)
{
    duet_box_query_result found;
    must(duet_box_query_run(a->boxes, DUET_OBJECT_POSES, q->boxes, ASKED, &found, ERR));
    add_bytes(a, found.hits, found.n_hits * sizeof *found.hits);
    if (!twin)
        return;
    verdicts v = make_verdicts(a);
    for (uint64_t k = 0; k < found.n_hits; ++k)
        ++v.found[found.hits[k].box * a->n + found.hits[k].id];
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id)
            v.right[i * a->n + id] = narrow_decide(&q->boxes[i], &a->poses[id], q->dims);
    assert_right(a, v, "box");
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
    duet_point_query_result inside, near;
    must(duet_point_query_run(a->inside, q->points, ASKED, &inside, ERR));
    must(duet_point_query_run(a->nearest, q->points, ASKED, &near, ERR));
    add_bytes(a, inside.hits, inside.n_hits * sizeof *inside.hits);
    add_bytes(a, near.hits, near.n_hits * sizeof *near.hits);
    if (!twin)
        return;
    verdicts v = make_verdicts(a);
    for (uint64_t k = 0; k < inside.n_hits; ++k)
        ++v.found[inside.hits[k].point * a->n + inside.hits[k].id];
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t id = 0; id < a->n; ++id) {
            const float *at = q->points[i].at;
            const duet_ray still = {.origin = {at[0], at[1], at[2]}};
            v.right[i * a->n + id] = ray_meets(&still, &a->poses[id], q->dims);
        }
    assert_right(a, v, "point");
    for (uint64_t k = 0; k < near.n_hits; ++k) {
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
    free(a->poses);
    a->poses = calloc((size_t)a->n + 1, sizeof *a->poses);
    must(duet_motion_get_poses(motion, a->poses, ERR));
    must(duet_tree_set_objects(a->tree, DUET_OBJECT_POSES, a->poses, a->n, ERR));
    a->sum = UINT64_C(0xcbf29ce484222325);
    ask_rays(a, q, twin);
    ask_sweeps(a, q, twin);
    ask_boxes(a, q, twin);
    ask_points(a, q, twin);
    return a->sum;
}
