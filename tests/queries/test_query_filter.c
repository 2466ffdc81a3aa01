// SPDX-License-Identifier: MIT
// Queries with a filter: what they find is what a query without one finds, filtered on the host.
#include "support/test.h"

#include "support/devices.h"
#include "support/trees.h"

#include "gen/gen.h"

enum { BOXES = 300, ITEMS = 400, NEAREST = 4 };

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 2, DUET_SHARE_ONE};

typedef struct scene {
    duet_rounded_box boxes[BOXES];
    duet_pose poses[BOXES];
    duet_filter filters[BOXES];
    duet_ray rays[ITEMS];
    duet_sweep sweeps[ITEMS];
    duet_rounded_sweep rounded_sweeps[ITEMS];
    duet_pose items[ITEMS];
    duet_rounded_box rounded_items[ITEMS];
    duet_point points[ITEMS];
} scene;

static duet_pose draw_pose(rng *r)
{
    duet_pose pose;
    turn_at_random(&pose, r);
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = (float)rng_between(r, -5, 5);
        pose.half_extents[k] = (float)rng_between(r, 0.2, 1);
    }
    return pose;
}

static scene *draw_scene(void)
{
    scene *s = test_alloc(sizeof *s);
    rng r = rng_seed(test_seed());
    for (int i = 0; i < BOXES; ++i) {
        s->poses[i] = draw_pose(&r);
        s->boxes[i] = (duet_rounded_box){s->poses[i], 0.25f};
        s->filters[i] = (duet_filter){1u << rng_below(&r, 4), (uint32_t)rng_below(&r, 16)};
    }
    for (int i = 0; i < ITEMS; ++i) {
        s->items[i] = draw_pose(&r);
        s->rounded_items[i] = (duet_rounded_box){s->items[i], 0.5f};
        s->rays[i].t_max = s->sweeps[i].t_max = 8;
        s->sweeps[i].box = s->items[i];
        for (int k = 0; k < 3; ++k) {
            s->rays[i].origin[k] = s->points[i].at[k] = (float)rng_between(&r, -6, 6);
            s->rays[i].direction[k] = s->sweeps[i].direction[k] = (float)rng_normal(&r);
        }
        s->rounded_sweeps[i] = (duet_rounded_sweep){.box = s->rounded_items[i], .t_max = 8};
        memcpy(s->rounded_sweeps[i].direction, s->sweeps[i].direction,
               sizeof s->sweeps[i].direction);
    }
    return s;
}

static bool can_touch(const duet_filter *a, const duet_filter *b)
{
    return (a->group & b->mask) && (b->group & a->mask);
}

// ---------------------------------------------------------------- one way to ask them all

typedef enum way {
    RAYS_CLOSEST,
    RAYS_ANY,
    RAYS_EVERY,
    SWEEPS_CLOSEST,
    SWEEPS_EVERY,
    BOX_JOIN,
    POINTS_INSIDE,
    POINTS_NEAREST,
    WAYS
} way;

static size_t hit_words(way w)
{
    return w == BOX_JOIN ? 2 : w == SWEEPS_CLOSEST || w == SWEEPS_EVERY ? 6 : 3;
}

// Copies of the hits; nearest: how many of each point.
static uint32_t *ask(const scene *s, duet_tree *tree, bool round, way w, uint32_t nearest,
                     const duet_filter *filter, uint64_t *n)
{
    const void *hits = NULL;
    void *query = NULL;
    if (w <= RAYS_EVERY) {
        duet_ray_query_def def = duet_default_ray_query_def();
        duet_ray_query_result result;
        def.tree = tree;
        def.filter = filter;
        def.wants = (duet_query_wants)w;
        query = kept(duet_ray_query_create(&def, ERR));
        must(duet_ray_query_run(query, s->rays, ITEMS, &result, ERR));
        hits = result.hits;
        *n = result.n_hits;
    } else if (w <= SWEEPS_EVERY) {
        duet_sweep_query_def def = duet_default_sweep_query_def();
        duet_sweep_query_result result;
        def.tree = tree;
        def.filter = filter;
        def.wants = w == SWEEPS_EVERY ? DUET_QUERY_EVERY : DUET_QUERY_CLOSEST;
        query = kept(duet_sweep_query_create(&def, ERR));
        result = run_sweeps(query, round ? DUET_OBJECT_ROUNDED_BOXES : DUET_OBJECT_POSES,
                            round ? (const void *)s->rounded_sweeps : s->sweeps, ITEMS);
        hits = result.hits;
        *n = result.n_hits;
    } else if (w == BOX_JOIN) {
        duet_box_query_def def = duet_default_box_query_def();
        duet_box_query_result result;
        def.tree = tree;
        def.filter = filter;
        query = kept(duet_box_query_create(&def, ERR));
        must(duet_box_query_run(query, round ? DUET_OBJECT_ROUNDED_BOXES : DUET_OBJECT_POSES,
                                round ? (const void *)s->rounded_items : s->items, ITEMS, &result,
                                ERR));
        hits = result.hits;
        *n = result.n_hits;
    } else {
        duet_point_query_def def = duet_default_point_query_def();
        duet_point_query_result result;
        def.tree = tree;
        def.filter = filter;
        def.nearest = w == POINTS_NEAREST ? nearest : 0;
        query = kept(duet_point_query_create(&def, ERR));
        must(duet_point_query_run(query, s->points, ITEMS, &result, ERR));
        hits = result.hits;
        *n = result.n_hits;
    }
    size_t bytes = *n * hit_words(w) * sizeof(uint32_t);
    uint32_t *copy = test_alloc(bytes + 1);
    if (bytes > 0)
        memcpy(copy, hits, bytes);
    return copy;
}

// ---------------------------------------------------------------- by brute force

// All hits without a filter, from which the host takes what the filter can touch.
static uint32_t *filter_hits(const scene *s, duet_tree *tree, bool round, way w,
                             const duet_filter *filter, uint64_t *n)
{
    size_t words = hit_words(w);
    uint64_t n_all, kept = 0;
    uint32_t *all = ask(s, tree, round, w, BOXES, NULL, &n_all);
    for (uint64_t i = 0; i < n_all; ++i)
        if (can_touch(filter, &s->filters[all[i * words + 1]]))
            memmove(all + kept++ * words, all + i * words, words * sizeof *all);
    *n = kept;
    return all;
}

// The answer of such a query for an item whose filtered hits these are.
static void assert_item(way w, const uint32_t *found, const uint32_t *known, uint64_t n_known)
{
    size_t words = hit_words(w);
    for (uint32_t i = 0; i < (w == POINTS_NEAREST ? NEAREST : 1); ++i) {
        if (i >= n_known)
            assert_int_equal(found[i * words + 1], DUET_NO_OBJECT);
        else if (w == RAYS_ANY)
            assert_int_equal(found[1], 0);
        else
            assert_memory_equal(found + i * words, known + i * words, words * sizeof *found);
    }
}

static void assert_filtered(const scene *s, duet_tree *tree, bool round, way w,
                            const duet_filter *filter)
{
    static const way all_of[WAYS] = {RAYS_EVERY,   RAYS_EVERY, RAYS_EVERY,    SWEEPS_EVERY,
                                     SWEEPS_EVERY, BOX_JOIN,   POINTS_INSIDE, POINTS_NEAREST};
    size_t words = hit_words(w);
    uint64_t n_found, n_known, at = 0;
    uint32_t *found = ask(s, tree, round, w, NEAREST, filter, &n_found);
    uint32_t *known = filter_hits(s, tree, round, all_of[w], filter, &n_known);
    if (w == all_of[w] && w != POINTS_NEAREST) {
        assert_int_equal(n_found, n_known);
        assert_memory_equal(found, known, n_known * words * sizeof *known);
        assert_true(filter->mask == 0 || n_known > ITEMS / 40);
    }
    for (uint32_t item = 0; (w != all_of[w] || w == POINTS_NEAREST) && item < ITEMS; ++item) {
        uint64_t first = at;
        while (at < n_known && known[at * words] == item)
            ++at;
        assert_item(w, found + item * (w == POINTS_NEAREST ? NEAREST : 1) * words,
                    known + first * words, at - first);
    }
}

TEST(a_query_finds_what_its_filter_can_touch)
{
    scene *s = draw_scene();
    const duet_filter filters[] = {{1, 3}, {6, 15}, {15, 0}};
    for (int round = 0; round < 2; ++round)
        for (int share = 0; share < 3; ++share) {
            duet_tree *tree = round ? open_rounded_tree(3, shares[share], DUET_OBJECT_ROUNDED_BOXES,
                                                        s->boxes, BOXES)
                                    : open_tree(3, shares[share], s->poses, BOXES);
            must(duet_tree_set_filters(tree, s->filters, BOXES, ERR));
            for (int w = 0; w < WAYS; ++w)
                assert_filtered(s, tree, round, (way)w, &filters[(w + share) % 3]);
        }
}

// ---------------------------------------------------------------- whose filters

static uint64_t count_rays(const scene *s, duet_tree *tree, duet_filter filter)
{
    uint64_t n;
    ask(s, tree, false, RAYS_EVERY, 0, &filter, &n);
    return n;
}

// Until the objects are set again; a run of the objects with each other has filters of its own.
TEST(objects_keep_their_filters_until_they_are_set)
{
    scene *s = draw_scene();
    const duet_filter all = {UINT32_MAX, UINT32_MAX}, some = {1, 1};
    duet_tree *tree = open_tree(3, DUET_SHARE_ONE / 2, s->poses, BOXES);
    uint64_t every = count_rays(s, tree, all);
    assert_int_equal(count_rays(s, tree, some), every);
    must(duet_tree_set_filters(tree, s->filters, BOXES, ERR));
    uint64_t few = count_rays(s, tree, some);
    assert_true(few > 0 && few < every);
    duet_box_query_def def = duet_default_box_query_def();
    duet_box_query_result result;
    def.tree = tree;
    duet_box_query *boxes = kept(duet_box_query_create(&def, ERR));
    must(duet_box_query_run_itself(boxes, NULL, 0, &result, ERR));
    assert_int_equal(count_rays(s, tree, some), few);
    must(duet_tree_set_share(tree, 0, ERR));
    assert_int_equal(count_rays(s, tree, some), few);
    must_fail(duet_tree_set_filters(tree, s->filters, BOXES - 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_int_equal(count_rays(s, tree, some), few);
    set_poses(tree, s->poses, BOXES);
    assert_int_equal(count_rays(s, tree, some), every);
}

TEST(bodies_of_a_motion_bring_their_filters)
{
    scene *s = draw_scene();
    duet_body bodies[BOXES];
    for (int i = 0; i < BOXES; ++i) {
        bodies[i] = duet_default_body();
        bodies[i].group = s->filters[i].group;
        bodies[i].mask = s->filters[i].mask;
    }
    duet_motion_def def = duet_default_motion_def();
    def.pair = default_pair();
    def.wants = DUET_EFFECT_CONTACT;
    duet_motion *motion = kept(duet_motion_create(&def, s->poses, bodies, BOXES, ERR));
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    const duet_filter some = {2, 6};
    for (int turn = 0; turn < 2; ++turn) {
        must(duet_tree_set_motion(tree, motion, ERR));
        must(duet_motion_get_poses(motion, s->poses, ERR));
        uint64_t found = count_rays(s, tree, some);
        set_poses(tree, s->poses, BOXES);
        must(duet_tree_set_filters(tree, s->filters, BOXES, ERR));
        assert_int_equal(found, count_rays(s, tree, some));
        for (int i = 0; i < BOXES; ++i) { // and a command changes them
            s->filters[i].group = bodies[i].group = 1u << i % 3;
            s->filters[i].mask = bodies[i].mask = (uint32_t)i % 8;
        }
        const duet_body_list list = {NULL, 0, BOXES};
        must(duet_motion_set_bodies(motion, list, DUET_BODY_FILTER, bodies, ERR));
    }
}

// ---------------------------------------------------------------- texts

static bool has_word(const char *kernel, int64_t filtered, const char *word)
{
    own(gen_variant) made = {0};
    gen *g = kept(gen_open(NULL, ERR));
    const gen_limits limits = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};
    const gen_setting settings[] = {{"FILTERED", filtered}};
    must(gen_make(g, kernel, settings, 1, &limits, &made, ERR));
    bool found = strstr(made.text, word);
    return found;
}

TEST(kernels_without_a_filter_have_no_word_of_it)
{
    static const char *const kernels[] = {"ray_query", "point_query", "box_query"};
    for (int i = 0; i < 3; ++i) {
        assert_true(has_word(kernels[i], 1, "can_touch"));
        assert_false(has_word(kernels[i], 0, "can_touch"));
        assert_false(has_word(kernels[i], 0, "uint group"));
        assert_false(has_word(kernels[i], 0, "FILTERED"));
        assert_true(i == 2 || !has_word(kernels[i], 0, "filter")); // boxes have them with ITSELF
    }
}
