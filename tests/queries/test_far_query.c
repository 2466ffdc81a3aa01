// SPDX-License-Identifier: MIT
// Trees in origin cells: the answers near 0 against exact arithmetic, and the same bits wherever
// the boxes are, whatever else is in the tree, on every device and share.
#include "support/test.h"

#include "base/compare.h"
#include "support/devices.h"
#include "support/hits.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/queries/ray.h"
#include "runtime/queries/sweep.h"

// Boxes reach over many cells, and all coordinates near 0 are multiples of 2^-8: offsets hold them.
#define EDGE 0.5f

enum { BOXES = 400, ASKED = 600, HALF = DUET_SHARE_ONE / 2 };

static const int32_t here[3] = {0, 0, 0};
static const int32_t there[3] = {1000000000, -900000001, 77};

// ---------------------------------------------------------------- scenes

static float some(rng *r, double reach)
{
    return (float)(rint(rng_between(r, -reach, reach) * 256) / 256);
}

// Every third stands upright.
static void fill_boxes(rng *r, duet_pose *poses, uint32_t n, uint32_t dims)
{
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = (duet_pose){.rotation = {0, 0, 0, 1}};
        for (uint32_t k = 0; k < 3; ++k) {
            poses[i].centre[k] = some(r, 6);
            poses[i].half_extents[k] = 0.125f + fabsf(some(r, i % 50 == 0 ? 3 : 0.5));
        }
        for (uint32_t k = 0; i % 3 > 0 && k < 4; ++k)
            poses[i].rotation[k] = dims == 2 && k < 2 ? 0 : (float)rng_normal(r);
    }
}

// A corner of the box where it stands upright.
static void take_corner(rng *r, const duet_pose *box, float point[3])
{
    for (int k = 0; k < 3; ++k)
        point[k] = box->centre[k] + (rng_below(r, 2) ? 1.0f : -1.0f) * box->half_extents[k];
}

// Many aim at corners and end there, or go along a face.
static void fill_rays(rng *r, duet_ray *rays, uint32_t n, const duet_pose *boxes)
{
    for (uint32_t i = 0; i < n; ++i) {
        float target[3];
        take_corner(r, &boxes[rng_below(r, BOXES)], target);
        rays[i] = (duet_ray){.t_max = i % 3 ? 1 : INFINITY};
        for (int k = 0; k < 3; ++k) {
            rays[i].origin[k] = some(r, 9);
            rays[i].direction[k] = i % 3 ? target[k] - rays[i].origin[k] : some(r, 1);
        }
        if (i % 5 == 0) {
            memcpy(rays[i].origin, target, sizeof target);
            memset(rays[i].direction, 0, sizeof target);
            rays[i].origin[i % 2] -= 16;
            rays[i].direction[i % 2] = i % 10 ? 16 : 0.25f;
        }
    }
}

// The same place in origin cells, moved by whole ones.
static duet_large_pose large_of(const duet_pose *pose, const int32_t by[3])
{
    duet_large_pose large = {.pose = *pose};
    memcpy(large.cell, by, sizeof large.cell);
    assert_true(origin_settle(&large, EDGE));
    return large;
}

typedef struct scene {
    duet_pose boxes[BOXES], asked[ASKED];
    duet_ray rays[ASKED];
    duet_point points[ASKED];
    // The same in cells; one box more, far away, moves the middle of the tree.
    duet_large_pose large_boxes[BOXES + 1], large_asked[ASKED];
    duet_large_ray large_rays[ASKED];
    duet_large_point large_points[ASKED];
    duet_large_sweep large_sweeps[ASKED]; // sweeps of the boxes asked about, along the rays
} scene;

static scene *make_scene(uint32_t dims)
{
    scene *s = test_alloc(sizeof *s);
    rng r = rng_seed(test_seed());
    fill_boxes(&r, s->boxes, BOXES, dims);
    fill_boxes(&r, s->asked, ASKED, dims);
    fill_rays(&r, s->rays, ASKED, s->boxes);
    for (uint32_t i = 0; i < ASKED; ++i)
        if (i % 2)
            take_corner(&r, &s->boxes[rng_below(&r, BOXES)], s->points[i].at);
        else
            for (int k = 0; k < 3; ++k)
                s->points[i].at[k] = some(&r, 9);
    return s;
}

// The items are not settled: offsets reach over many cells.
static void move_scene(scene *s, const int32_t by[3])
{
    for (uint32_t i = 0; i < BOXES; ++i)
        s->large_boxes[i] = large_of(&s->boxes[i], by);
    for (uint32_t i = 0; i < ASKED; ++i) {
        s->large_asked[i] = (duet_large_pose){s->asked[i], {by[0], by[1], by[2]}, 0};
        s->large_rays[i] = (duet_large_ray){s->rays[i], {by[0], by[1], by[2]}};
        s->large_sweeps[i] = (duet_large_sweep){.box = s->asked[i], .t_max = s->rays[i].t_max};
        memcpy(s->large_sweeps[i].cell, by, sizeof s->large_sweeps[i].cell);
        memcpy(s->large_sweeps[i].direction, s->rays[i].direction, sizeof s->rays[i].direction);
        s->large_points[i] = (duet_large_point){s->points[i], {by[0], by[1], by[2]}};
    }
    s->large_boxes[BOXES] = (duet_large_pose){
        s->boxes[0], {by[0] - 1000000000, by[1] + (1 << 28), 1 << 29}, 0}; // no ray goes there
}

static duet_tree *open_far_tree(uint32_t dims, uint32_t share, const duet_large_pose *boxes,
                                uint32_t n)
{
    duet_tree_def def = duet_default_tree_def();
    def.pair = default_pair();
    def.dims = dims;
    def.share = share;
    def.origin_edge = EDGE;
    duet_tree *tree = kept(duet_tree_create(&def, ERR));
    must(duet_tree_set_objects(tree, DUET_OBJECT_LARGE_POSES, boxes, n, ERR));
    return tree;
}

// A question, and its answer in memory of the caller.
typedef struct answer {
    void *hits;
    uint64_t n;
    size_t bytes;
} answer;

typedef void ask(const scene *s, duet_tree *tree, int what, answer *found);

static void keep(answer *a, const void *hits, uint64_t n, size_t bytes)
{
    *a = (answer){test_alloc((size_t)n * bytes + 1), n, (size_t)n * bytes};
    if (n > 0)
        memcpy(a->hits, hits, a->bytes);
}

static void ask_rays(const scene *s, duet_tree *tree, int wants, answer *found)
{
    duet_ray_query_result result;
    duet_ray_query *query = open_ray_query(tree, (duet_query_wants)wants, false);
    must(duet_ray_query_run_large(query, s->large_rays, ASKED, &result, ERR));
    keep(found, result.hits, result.n_hits, sizeof *result.hits);
}

static void ask_points(const scene *s, duet_tree *tree, int nearest, answer *found)
{
    duet_point_query_result result;
    duet_point_query *query = open_point_query(tree, (uint32_t)nearest);
    must(duet_point_query_run_large(query, s->large_points, ASKED, &result, ERR));
    keep(found, result.hits, result.n_hits, sizeof *result.hits);
}

static void ask_sweeps(const scene *s, duet_tree *tree, int wants, answer *found)
{
    duet_sweep_query_result result;
    duet_sweep_query *query = open_sweep_query(tree, (duet_query_wants)wants);
    must(
        duet_sweep_query_run(query, DUET_OBJECT_LARGE_POSES, s->large_sweeps, ASKED, &result, ERR));
    keep(found, result.hits, result.n_hits, sizeof *result.hits);
}

// level: or -1, the tree against itself.
static void ask_boxes(const scene *s, duet_tree *tree, int level, answer *found)
{
    duet_box_query_result result;
    duet_box_query_def def = duet_default_box_query_def();
    def.tree = tree;
    def.level = level < 0 ? DUET_LEVEL_CERTIFIED : (duet_level)level;
    duet_box_query *query = kept(duet_box_query_create(&def, ERR));
    must(level < 0 ? duet_box_query_run_itself(query, NULL, 0, &result, ERR)
                   : duet_box_query_run(query, DUET_OBJECT_LARGE_POSES, s->large_asked, ASKED,
                                        &result, ERR));
    keep(found, result.hits, result.n_hits, sizeof *result.hits);
}

static hit_list hits_of(const answer *a)
{
    return hit_list_of(a->hits, a->n, a->n > 0 ? a->bytes / a->n : 0, BOXES);
}

// ---------------------------------------------------------------- everywhere the same

static void same_answers(const answer *a, const answer *b)
{
    assert_int_equal(a->n, b->n);
    assert_memory_equal(a->hits, b->hits, a->bytes);
}

// Near 0; far away on the other device; with a middle that is 2^28 cells off.
static answer ask_everywhere(scene *s, ask *kind, int what, uint32_t dims)
{
    answer near, far, other;
    move_scene(s, here);
    duet_tree *tree = open_far_tree(dims, 0, s->large_boxes, BOXES);
    kind(s, tree, what, &near);
    move_scene(s, there);
    tree = open_far_tree(dims, HALF, s->large_boxes, BOXES);
    kind(s, tree, what, &far);
    must(duet_tree_set_objects(tree, DUET_OBJECT_LARGE_POSES, s->large_boxes, BOXES + 1, ERR));
    kind(s, tree, what, &other);
    same_answers(&near, &far);
    same_answers(&near, &other);
    return near;
}

// ---------------------------------------------------------------- rays

static void all_hits_of_rays_are_those_of_integers_in(uint32_t dims)
{
    scene *s = make_scene(dims);
    answer found = ask_everywhere(s, ask_rays, DUET_QUERY_EVERY, dims);
    hit_list hits = hits_of(&found);
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t k = 0; k < BOXES; ++k)
            expect_hit(&hits, i, k, ray_meets_exactly(&s->rays[i], &s->boxes[k], dims));
    expect_no_more(&hits, ASKED);
    for (const duet_ray_hit *hit = found.hits; (const char *)hit < hits.next; ++hit)
        assert_true(hit->t >= 0 && hit->t <= s->rays[hit->ray].t_max);
}

TEST(all_hits_of_rays_are_those_of_integers_wherever_they_are)
{
    all_hits_of_rays_are_those_of_integers_in(2);
    all_hits_of_rays_are_those_of_integers_in(3);
}

// The closest hits are the first of all hits, t included.
TEST(a_closest_hit_is_the_first_of_all)
{
    scene *s = make_scene(3);
    answer closest = ask_everywhere(s, ask_rays, DUET_QUERY_CLOSEST, 3);
    answer every;
    duet_tree *tree = open_far_tree(3, HALF, s->large_boxes, BOXES);
    ask_rays(s, tree, DUET_QUERY_EVERY, &every);
    const duet_ray_hit *first = closest.hits;
    hit_list hits = hits_of(&every);
    for (uint32_t i = 0; i < ASKED; ++i) {
        const duet_ray_hit none = {i, DUET_NO_OBJECT, INFINITY}, *nearest = take_hits(&hits, i);
        assert_memory_equal(&first[i], nearest ? nearest : &none, sizeof none);
    }
}

// The surface of a box that stands upright that a ray enters is known.
TEST(t_is_where_the_ray_enters_as_exactly_as_near_0)
{
    scene *s = make_scene(3);
    answer found = ask_everywhere(s, ask_rays, DUET_QUERY_EVERY, 3);
    uint32_t n_seen = 0;
    for (uint64_t i = 0; i < found.n; ++i) {
        const duet_ray_hit *hit = (const duet_ray_hit *)found.hits + i;
        const duet_ray *ray = &s->rays[hit->ray];
        const duet_pose *box = &s->boxes[hit->id];
        double enter = 0, size = 0, speed = 0;
        for (int k = 0; k < 3; ++k) {
            double way = (double)ray->origin[k] - box->centre[k], go = ray->direction[k];
            double in = go == 0 ? 0 : (-copysign(box->half_extents[k], go) - way) / go;
            size += fabs(way) + box->half_extents[k];
            speed = in > enter ? fabs(go) : speed;
            enter = fmax(enter, in);
        }
        if (hit->id % 3 != 0)
            continue;
        ++n_seen;
        assert_true(fabs(hit->t - enter) <= 64 * 0x1p-24 * size / fmax(speed, 0x1p-20));
        assert_true(enter > 0 || hit->t == 0);
    }
    assert_true(n_seen > 100);
}

// A ray across the whole of what cells can say, along the face of a box at its other end.
TEST(a_face_is_met_or_missed_by_a_quantum_a_billion_cells_away)
{
    const int32_t far = (1 << 30) - 4;
    duet_large_pose box = {{{0}, {1, 1, 1}, {0, 0, 0, 1}}, {far, far, -far}, 0};
    duet_large_ray rays[4];
    for (int i = 0; i < 4; ++i)
        rays[i] = (duet_large_ray){{{0, 0, 0}, {1, 0, 0}, INFINITY}, {-far, far + 2, -far}};
    rays[1].ray.origin[1] = EDGE * 0x1p-24f; // above its upper face
    rays[2].cell[2] -= 2;                    // along an edge
    rays[3] = rays[2];
    rays[3].ray.origin[2] = -EDGE * 0x1p-24f;
    scene *s = test_alloc(sizeof *s);
    for (uint32_t i = 0; i < ASKED; ++i)
        s->large_rays[i] = rays[i % 4];
    duet_tree *tree = open_far_tree(3, HALF, &box, 1);
    answer found;
    ask_rays(s, tree, DUET_QUERY_CLOSEST, &found);
    const duet_ray_hit *hits = found.hits;
    for (uint32_t i = 0; i < ASKED; ++i)
        assert_int_equal(hits[i].id, i % 4 == 0 || i % 4 == 2 ? 0 : DUET_NO_OBJECT);
    assert_float_equal(hits[0].t, 2.0 * far * EDGE, 256);
}

// ---------------------------------------------------------------- points and boxes

TEST(points_lie_in_the_boxes_that_integers_say)
{
    scene *s = make_scene(3);
    answer found = ask_everywhere(s, ask_points, 0, 3);
    hit_list hits = hits_of(&found);
    for (uint32_t i = 0; i < ASKED; ++i) {
        duet_ray still = {.t_max = 0};
        memcpy(still.origin, s->points[i].at, sizeof still.origin);
        for (uint32_t k = 0; k < BOXES; ++k)
            expect_hit(&hits, i, k, ray_meets_exactly(&still, &s->boxes[k], 3));
    }
    expect_no_more(&hits, ASKED / 4);
}

static double distance_to(const duet_pose *box, const float point[3])
{
    double axis[3][3], square = 0;
    narrow_axes(axis, box->rotation);
    for (int i = 0; i < 3; ++i) {
        double at = 0;
        for (int k = 0; k < 3; ++k)
            at += axis[i][k] * ((double)point[k] - box->centre[k]);
        double beyond = fmax(fabs(at) - box->half_extents[i], 0);
        square += beyond * beyond;
    }
    return sqrt(square);
}

TEST(the_nearest_are_those_of_a_sweep)
{
    enum { NEAREST = 5 };
    scene *s = make_scene(3);
    answer found = ask_everywhere(s, ask_points, NEAREST, 3);
    const duet_point_hit *hits = found.hits;
    double distances[BOXES];
    assert_int_equal(found.n, ASKED * NEAREST);
    for (uint32_t i = 0; i < ASKED; ++i) {
        for (uint32_t k = 0; k < BOXES; ++k)
            distances[k] = distance_to(&s->boxes[k], s->points[i].at);
        for (int k = 0; k < NEAREST; ++k)
            assert_float_equal(hits[NEAREST * i + k].distance, distances[hits[NEAREST * i + k].id],
                               1e-4);
        qsort(distances, BOXES, sizeof *distances, compare_double);
        for (int k = 0; k < NEAREST; ++k)
            assert_float_equal(hits[NEAREST * i + k].distance, distances[k], 1e-4);
    }
}

TEST(boxes_meet_where_integers_say_so)
{
    scene *s = make_scene(3);
    answer found = ask_everywhere(s, ask_boxes, DUET_LEVEL_CERTIFIED, 3);
    answer itself = ask_everywhere(s, ask_boxes, -1, 3);
    hit_list hits = hits_of(&found), pairs = hits_of(&itself);
    for (uint32_t i = 0; i < ASKED; ++i)
        for (uint32_t k = 0; k < BOXES; ++k) {
            expect_hit(&hits, i, k, narrow_decide(&s->asked[i], &s->boxes[k], 3));
            expect_hit(&pairs, i, k, i < k && narrow_decide(&s->boxes[i], &s->boxes[k], 3));
        }
    expect_no_more(&hits, ASKED / 4);
    expect_no_more(&pairs, BOXES / 4);
}

// And t and the normal are those of the same sweep near 0.
TEST(sweeps_meet_what_integers_say)
{
    scene *s = make_scene(3);
    answer found = ask_everywhere(s, ask_sweeps, DUET_QUERY_EVERY, 3);
    hit_list hits = hits_of(&found);
    for (uint32_t i = 0; i < ASKED; ++i) {
        duet_sweep sweep = {.box = s->asked[i], .t_max = s->rays[i].t_max};
        memcpy(sweep.direction, s->rays[i].direction, sizeof sweep.direction);
        const duet_sweep_hit *hit = take_hits(&hits, i);
        for (uint32_t k = 0; k < hits.n; ++k) {
            float normal[3], t = sweep_enter(&sweep, &s->boxes[hit[k].id], 3, normal);
            assert_true(hit[k].t == t);
            assert_memory_equal(hit[k].normal, normal, sizeof normal);
        }
        for (uint32_t k = i % 4; k < BOXES; k += 4) // integers take long
            expect_hit(&hits, i, k, sweep_meets_exactly(&sweep, &s->boxes[k], 3));
    }
    expect_no_more(&hits, ASKED);
}

TEST(cheaper_levels_answer_alike_everywhere)
{
    scene *s = make_scene(3);
    answer aabb = ask_everywhere(s, ask_boxes, DUET_LEVEL_AABB, 3);
    answer axes = ask_everywhere(s, ask_boxes, DUET_LEVEL_SAT15, 3);
    assert_true(aabb.n > axes.n && axes.n > ASKED);
}

// ---------------------------------------------------------------- many, and bodies

// So many that they are sorted by where they begin.
TEST(many_are_answered_as_few)
{
    enum { MANY = 15 * ASKED };
    scene *s = make_scene(3);
    answer few;
    move_scene(s, there);
    duet_tree *tree = open_far_tree(3, 0, s->large_boxes, BOXES + 1);
    ask_rays(s, tree, DUET_QUERY_CLOSEST, &few);
    duet_large_ray *rays = test_alloc(MANY * sizeof *rays);
    for (uint32_t i = 0; i < MANY; ++i)
        rays[i] = s->large_rays[i % ASKED];
    duet_ray_query_def def = duet_default_ray_query_def();
    def.tree = tree;
    duet_ray_query *query = kept(duet_ray_query_create(&def, ERR));
    duet_ray_query_result found;
    must(duet_ray_query_run_large(query, rays, MANY, &found, ERR));
    const duet_ray_hit *hits = few.hits;
    for (uint32_t i = 0; i < MANY; ++i) {
        assert_int_equal(found.hits[i].id, hits[i % ASKED].id);
        assert_true(found.hits[i].t == hits[i % ASKED].t);
    }
}

TEST(a_gpu_gives_the_same_answers)
{
    const struct {
        ask *kind;
        int what;
    } asks[] = {{ask_rays, DUET_QUERY_CLOSEST},
                {ask_points, 3},
                {ask_sweeps, DUET_QUERY_CLOSEST},
                {ask_boxes, DUET_LEVEL_CERTIFIED}};
    scene *s = make_scene(3);
    answer found[2];
    move_scene(s, there);
    for (size_t i = 0; i < sizeof asks / sizeof *asks; ++i) {
        for (int gpu = 0; gpu < 2; ++gpu) {
            devices_seem_gpus(gpu);
            duet_tree *tree = open_far_tree(3, 0, s->large_boxes, BOXES);
            asks[i].kind(s, tree, asks[i].what, &found[gpu]);
        }
        devices_seem_gpus(false);
        assert_true(found[0].n > 0);
        same_answers(&found[0], &found[1]);
    }
}

// Bodies fall alike near 0 and far away, and rays see them alike.
TEST(bodies_of_a_motion_are_seen_where_they_are)
{
    scene *s = make_scene(3);
    const int32_t *const at[2] = {here, there};
    answer seen[2];
    for (int i = 0; i < 2; ++i) {
        duet_motion_def def = duet_default_motion_def();
        def.pair = default_pair();
        def.origin_edge = EDGE;
        def.gravity[2] = -9.81;
        for (int k = 0; k < 3; ++k)
            def.origin[k] = (double)at[i][k] * EDGE;
        duet_motion *motion = kept(duet_motion_create(&def, s->boxes, NULL, BOXES, ERR));
        duet_motion_result result;
        for (int step = 0; step < 20; ++step)
            must(duet_motion_advance(motion, &result, ERR));
        move_scene(s, at[i]);
        duet_tree *tree = open_far_tree(3, 0, NULL, 0);
        must(duet_tree_set_motion(tree, motion, ERR));
        ask_rays(s, tree, DUET_QUERY_CLOSEST, &seen[i]);
        duet_state body;
        const uint32_t id = ((const duet_ray_hit *)seen[i].hits)[4].id;
        assert_true(id < BOXES);
        duet_state *states = test_alloc(BOXES * sizeof *states);
        must(duet_motion_get_states(motion, states, ERR));
        body = states[id];
        assert_float_equal(body.centre[2] - def.origin[2], s->boxes[id].centre[2] - 0.55, 0.1);
    }
    same_answers(&seen[0], &seen[1]);
}

TEST(a_motion_with_other_cells_is_refused)
{
    const duet_pose box = {{0}, {1, 1, 1}, {0, 0, 0, 1}};
    duet_motion_def def = duet_default_motion_def();
    def.pair = default_pair();
    duet_motion *motion = kept(duet_motion_create(&def, &box, NULL, 1, ERR));
    duet_tree *tree = open_far_tree(3, 0, NULL, 0);
    must_fail(duet_tree_set_motion(tree, motion, ERR), DUET_STATUS_BAD_ARGUMENT,
              "origin_edge 0; the tree has 0.5");
}

// ---------------------------------------------------------------- refusals

TEST(what_has_no_cells_is_refused_by_name)
{
    duet_large_pose box = {{{0}, {1, 1, 1}, {0, 0, 0, 1}}, {5, 6, 7}, 0};
    duet_tree *tree = open_far_tree(3, 0, &box, 1);
    duet_ray_query_def def = duet_default_ray_query_def();
    def.tree = tree;
    duet_ray_query *query = kept(duet_ray_query_create(&def, ERR));
    duet_ray_query_result result;
    duet_large_ray rays[2] = {{{{0}, {1, 0, 0}, 1}, {5, 6, 7}}, {{{0}, {1, 0, 0}, 1}, {1 << 30}}};
    must_fail(duet_ray_query_run(query, &rays[0].ray, 1, &result, ERR), DUET_STATUS_BAD_ARGUMENT,
              "rays without origin cells");
    must_fail(duet_ray_query_run_large(query, rays, 2, &result, ERR), DUET_STATUS_BAD_OBJECT,
              "ray 1:");
    must_fail(duet_tree_set_objects(tree, DUET_OBJECT_POSES, &box.pose, 1, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    box.cell[1] = -(1 << 30);
    must_fail(duet_tree_set_objects(tree, DUET_OBJECT_LARGE_POSES, &box, 1, ERR),
              DUET_STATUS_BAD_OBJECT, "object 0");
}

TEST(an_edge_that_is_none_is_refused)
{
    const float edges[] = {3, -1, NAN, 0x1p70f, 0x1p-101f};
    duet_tree_def def = duet_default_tree_def();
    def.pair = default_pair();
    for (size_t i = 0; i < sizeof edges / sizeof *edges; ++i) {
        def.origin_edge = edges[i];
        must_fail(duet_tree_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "origin_edge");
    }
    def.origin_edge = 1;
    def.shape = DUET_SHAPE_SPHERES;
    must_fail(duet_tree_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "origin cells are for poses");
}
