// SPDX-License-Identifier: MIT
// Boxes against a tree: every hit against a sweep over all pairs on the host, at every level
// against a pair query, and a world with itself.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/hits.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"

static duet_box_query *open_query(duet_tree *tree, duet_level level)
{
    duet_box_query_def def = duet_default_box_query_def();
    def.tree = tree;
    def.level = level;
    return kept(duet_box_query_create(&def, ERR));
}

enum { BOXES = 700, ASKED = 400 };

// Hard pairs: one of each is asked, the other in the tree, and some big ones meet many.
static void fill(uint32_t dims, duet_pose *boxes, duet_pose *asked)
{
    rng r = rng_seed(test_seed());
    uint32_t n_classes = 0;
    while (hard_classes[n_classes].name)
        ++n_classes;
    for (uint32_t i = 0; i < BOXES; ++i) {
        hard_pair pair = hard_classes[i % n_classes].make(&r, dims);
        boxes[i] = pair.b;
        if (i < ASKED)
            asked[i] = pair.a;
    }
}

// Poses of hard classes that no query takes are left out of the comparison.
static bool is_taken(const duet_pose *pose, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        if (fabsf(pose->centre[k]) > 0x1p100f || pose->half_extents[k] > 0x1p100f)
            return false;
    return narrow_is_box(pose, dims);
}

static uint32_t keep_taken(duet_pose *poses, uint32_t n, uint32_t dims)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; ++i)
        if (is_taken(&poses[i], dims))
            poses[kept++] = poses[i];
    return kept;
}

static void hits_are_those_of_a_sweep_in(uint32_t dims, uint32_t share)
{
    duet_pose *boxes = test_alloc(BOXES * sizeof *boxes);
    duet_pose *asked = test_alloc(ASKED * sizeof *asked);
    fill(dims, boxes, asked);
    uint32_t n = keep_taken(boxes, BOXES, dims), m = keep_taken(asked, ASKED, dims);
    assert_true(n > BOXES / 2 && m > ASKED / 2);
    duet_tree *tree = open_tree(dims, share, boxes, n);
    duet_box_query *query = open_query(tree, DUET_LEVEL_CERTIFIED);
    duet_box_query_result found = join_boxes(query, DUET_OBJECT_POSES, asked, m);
    hit_list hits = HITS(found, n);
    for (uint32_t i = 0; i < m; ++i)
        for (uint32_t id = 0; id < n; ++id)
            expect_hit(&hits, i, id,
                       (i + id) % 64 == 0 ? narrow_exact(&asked[i], &boxes[id], dims)
                                          : narrow_decide(&asked[i], &boxes[id], dims));
    expect_no_more(&hits, m / 4);
    assert_true(found.undecided > 0);
    print_message("%uD: %" PRIu64 " hits, %" PRIu64 " undecided\n", dims, found.n_hits,
                  found.undecided);
}

TEST(hits_are_those_of_a_sweep)
{
    hits_are_those_of_a_sweep_in(3, DUET_SHARE_ONE / 3);
    hits_are_those_of_a_sweep_in(2, 0);
}

// Answers all pairs of these two sets, as a pair query answers.
static uint64_t count_by_pairs(duet_level level, const duet_pose *boxes, uint32_t n,
                               const duet_pose *asked, uint32_t m,
                               const duet_box_query_result *found)
{
    duet_pair_query_def def = duet_default_pair_query_def();
    duet_pair_query_result result;
    def.pair = default_pair();
    def.level = level;
    duet_pair_query *test = kept(duet_pair_query_create(&def, ERR));
    duet_pose *pairs = test_alloc((size_t)n * m * 2 * sizeof *pairs);
    uint8_t *answers = test_alloc((size_t)n * m);
    for (uint64_t i = 0; i < (uint64_t)n * m; ++i) {
        pairs[2 * i] = asked[i / n];
        pairs[2 * i + 1] = boxes[i % n];
    }
    must(duet_pair_query_run(test, pairs, (uint64_t)n * m, answers, NULL, &result, ERR));
    for (uint64_t i = 0; i < found->n_hits; ++i)
        assert_true(answers[(uint64_t)found->hits[i].box * n + found->hits[i].id] == 1);
    return result.colliding;
}

TEST(every_level_answers_as_a_pair_query)
{
    enum { N = 150, M = 100 };
    duet_pose boxes[N], asked[M];
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 4; ++k) {
            duet_pose *of[] = {&boxes[i], &asked[i % M]};
            for (int which = 0; which < 2; ++which) {
                of[which]->rotation[k] = (float)rng_normal(&r);
                if (k < 3) {
                    of[which]->centre[k] = (float)rng_between(&r, 0, 4);
                    of[which]->half_extents[k] = (float)rng_between(&r, 0.1, 0.6);
                }
            }
        }
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 2, boxes, N);
    uint64_t bounds_hits = 0;
    for (int level = 0; level < DUET_LEVELS; ++level) {
        duet_box_query *query = open_query(tree, (duet_level)level);
        duet_box_query_result found = join_boxes(query, DUET_OBJECT_POSES, asked, M);
        assert_int_equal(found.n_hits,
                         count_by_pairs((duet_level)level, boxes, N, asked, M, &found));
        bounds_hits = level == DUET_LEVEL_AABB ? found.n_hits : bounds_hits;
        assert_true(level <= DUET_LEVEL_AABB || found.n_hits < bounds_hits);
    }
}

TEST(bounds_meet_where_comparisons_say_so)
{
    enum { N = 600 };
    duet_bounds bounds[N];
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) {
            bounds[i].lower[k] = (float)rng_below(&r, 20);
            bounds[i].upper[k] = bounds[i].lower[k] + (float)rng_below(&r, 4);
        }
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_tree *tree = open_bounds_tree(dims, DUET_SHARE_ONE / 4, bounds, N);
        duet_box_query *query = open_query(tree, DUET_LEVEL_CERTIFIED);
        duet_box_query_result found = join_boxes(query, DUET_OBJECT_BOUNDS, bounds, N);
        hit_list hits = HITS(found, N);
        for (uint32_t i = 0; i < N; ++i)
            for (uint32_t id = 0; id < N; ++id)
                expect_hit(&hits, i, id, narrow_bounds(&bounds[i], &bounds[id], dims));
        expect_no_more(&hits, N);
    }
}

// Keeps of all pairs those whose filters let them touch, in their order.
static void meets_itself(duet_box_query *query, const duet_filter *filters, uint32_t count,
                         const duet_pair *pairs, uint64_t n)
{
    duet_box_query_result found;
    uint64_t at = 0;
    must(duet_box_query_run_itself(query, filters, filters ? count : 0, &found, ERR));
    for (uint64_t i = 0; i < n; ++i) {
        uint32_t a = pairs[i].a, b = pairs[i].b;
        if (filters && !(filters[a].group & filters[b].mask && filters[b].group & filters[a].mask))
            continue;
        assert_true(at < found.n_hits && found.hits[at].box == a && found.hits[at].id == b);
        ++at;
    }
    assert_true(at == found.n_hits && at > 0 && (at < n || !filters));
}

// A tree without objects, and one with a body that was taken out of its motion.
TEST(what_is_not_there_meets_nothing)
{
    const duet_pose poses[3] = {{{0}, {1, 1, 1}, {0, 0, 0, 1}},
                                {{0}, {1, 1, 1}, {0, 0, 0, 1}},
                                {{1}, {1, 1, 1}, {0, 0, 0, 1}}};
    duet_box_query_result found;
    duet_motion_def def = duet_default_motion_def();
    def.pair = default_pair();
    def.wants = DUET_EFFECT_CONTACT;
    duet_motion *motion = kept(duet_motion_create(&def, poses, NULL, 3, ERR));
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 3, NULL, 0);
    duet_box_query *query = open_query(tree, DUET_LEVEL_CERTIFIED);
    must(duet_box_query_run_itself(query, NULL, 0, &found, ERR));
    assert_int_equal(found.n_hits, 0);
    must(duet_motion_remove_bodies(motion, (duet_body_list){.first = 1, .n = 1}, ERR));
    must(duet_tree_set_motion(tree, motion, ERR));
    must(duet_box_query_run_itself(query, NULL, 0, &found, ERR));
    assert_int_equal(found.n_hits, 1);
    assert_true(found.hits[0].box == 0 && found.hits[0].id == 2);
}

// Enough boxes to be sorted before they are asked about, and lists that grow.
TEST(a_set_joined_with_itself_has_a_worlds_pairs)
{
    enum { N = 20000 };
    duet_pose *poses = test_alloc(N * sizeof *poses);
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 4; ++k) {
            poses[i].rotation[k] = (float)rng_normal(&r);
            if (k < 3) {
                poses[i].centre[k] = (float)rng_between(&r, 0, 25);
                poses[i].half_extents[k] = 0.5f;
            }
        }
    duet_world_def def = duet_default_world_def();
    duet_result result;
    def.pair = default_pair();
    duet_world *world = create_world_of(&def, DUET_OBJECT_POSES, poses, N);
    must(duet_world_step(world, &result, ERR));
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 3, poses, N);
    duet_box_query *query = open_query(tree, DUET_LEVEL_CERTIFIED);
    duet_box_query_result found = join_boxes(query, DUET_OBJECT_POSES, poses, N);
    assert_int_equal(found.n_hits, N + 2 * result.pairs);
    duet_pair *pairs = test_alloc((size_t)result.pairs * sizeof *pairs);
    uint64_t n = 0;
    for (uint64_t i = 0; i < found.n_hits; ++i)
        if (found.hits[i].box < found.hits[i].id)
            pairs[n++] = (duet_pair){found.hits[i].box, found.hits[i].id};
    assert_int_equal(n, result.pairs);
    assert_true(duet_pairs_hash(pairs, n) == duet_result_get_hash(&result));
    duet_filter *filters = test_alloc(N * sizeof *filters);
    for (uint32_t i = 0; i < N; ++i)
        filters[i] = (duet_filter){1u << rng_below(&r, 4), rng_below(&r, 16)};
    meets_itself(query, NULL, N, pairs, n);
    meets_itself(query, filters, N, pairs, n);
}

TEST(what_is_no_box_is_refused_by_its_number)
{
    const duet_pose good = {{0}, {1, 1, 1}, {0, 0, 0, 1}};
    duet_pose asked[3] = {good, good, good};
    duet_box_query_result found;
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 2, &good, 1);
    duet_box_query *query = open_query(tree, DUET_LEVEL_CERTIFIED);
    test_give_back(tree); // the query holds it
    asked[2].half_extents[1] = -1;
    must_fail(duet_box_query_run(query, DUET_OBJECT_POSES, asked, 3, &found, ERR),
              DUET_STATUS_BAD_OBJECT, "box 2:");
    assert_int_equal(join_boxes(query, DUET_OBJECT_POSES, asked, 2).n_hits, 2);
    assert_int_equal(join_boxes(query, DUET_OBJECT_POSES, NULL, 0).n_hits, 0);
}
