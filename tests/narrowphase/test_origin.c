// SPDX-License-Identifier: MIT
// Boxes in origin cells: the same answers wherever they are.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/kernels.h"
#include "support/large.h"
#include "support/oracle.h"
#include "support/scene_file.h"

#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/origin.h"

// ------------------------------------------------------------ positions

TEST(a_position_is_kept_to_2_25_of_an_edge_anywhere)
{
    rng r = rng_seed(test_seed());
    const float edges[] = {1, 0x1p-4f, 1024};
    for (int i = 0; i < 30000; ++i) {
        float edge = edges[i % 3];
        double at[3];
        duet_large_pose p = {.cell = {7, 7, 7}};
        for (int k = 0; k < 3; ++k)
            at[k] = rng_between(&r, -1e7, 1e7);
        must(duet_large_pose_set(&p, at, edge, ERR));
        for (int k = 0; k < 3; ++k) {
            assert_true(p.pose.centre[k] >= 0 && p.pose.centre[k] < edge);
            double there = (double)p.cell[k] * edge + p.pose.centre[k];
            assert_true(fabs(there - at[k]) <= edge * 0x1p-25);
        }
    }
}

TEST(an_offset_outside_its_cell_is_settled_in_another)
{
    duet_large_pose p = {{{-0.25f, 3.5f, 0}, {1, 1, 1}, {0, 0, 0, 1}}, {10, 10, 10}, 0};
    assert_true(origin_settle(&p, 1));
    assert_int_equal(p.cell[0], 9);
    assert_int_equal(p.cell[1], 13);
    assert_true(p.pose.centre[0] == 0.75f && p.pose.centre[1] == 0.5f && p.pose.centre[2] == 0);
}

TEST(what_is_too_far_or_no_edge_is_refused)
{
    duet_large_pose p = {0};
    must_fail(duet_large_pose_set(&p, (double[]){0, 2e9, 0}, 1, ERR), DUET_STATUS_BAD_OBJECT, "");
    must_fail(duet_large_pose_set(&p, (double[]){0, NAN, 0}, 1, ERR), DUET_STATUS_BAD_OBJECT, "");
    const float wrong[] = {0, -1, 3, INFINITY, NAN};
    for (int i = 0; i < 5; ++i)
        must_fail(duet_large_pose_set(&p, (double[]){0, 0, 0}, wrong[i], ERR),
                  DUET_STATUS_BAD_ARGUMENT, "");
}

// ------------------------------------------------------------ pairs

static duet_large_pose place(const duet_pose *pose, const double by[3])
{
    duet_large_pose p = {.pose = *pose};
    double at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = by[k] + (double)pose->centre[k];
    assert_true(origin_place(&p, at, 1));
    return p;
}

static bool is_near(const hard_pair *pair)
{
    for (int k = 0; k < 3; ++k)
        if (!(fabsf(pair->a.centre[k]) < 1e6f && fabsf(pair->b.centre[k]) < 1e6f))
            return false;
    return true;
}

static bool at_level(int level, const duet_large_pose both[2], uint32_t dims)
{
    double shift[3];
    origin_shift(shift, both, 1, 0, 1);
    return level_collide((duet_level)level, &both[0].pose, &both[1].pose, shift, dims, true);
}

// The pair as it lies near 0, moved by whole cells and by whole quanta.
static void check_moved(const hard_pair *pair, uint32_t dims, rng *r)
{
    const double nowhere[3] = {0};
    duet_large_pose near[2] = {place(&pair->a, nowhere), place(&pair->b, nowhere)};
    duet_large_pose far[2] = {near[0], near[1]}, off[2] = {near[0], near[1]};
    for (int k = 0; k < 3; ++k) {
        int32_t cells = (int32_t)rng_between(r, -1e7, 1e7);
        double quanta = 0x1p-24 * rng_below(r, 1u << 24);
        for (int i = 0; i < 2; ++i) {
            double moved = off[i].pose.centre[k] + quanta;
            far[i].cell[k] += cells;
            off[i].cell[k] += cells + (moved >= 1);
            off[i].pose.centre[k] = (float)fmod(moved, 1);
        }
    }
    bool collide = duet_large_poses_collide(&near[0], &near[1], 1, dims);
    assert_int_equal(duet_large_poses_collide(&far[0], &far[1], 1, dims), collide);
    assert_int_equal(duet_large_poses_collide(&off[0], &off[1], 1, dims), collide);
    assert_int_equal(duet_large_poses_collide(&off[1], &off[0], 1, dims), collide);
    for (int l = 0; l < DUET_LEVELS; ++l)
        assert_int_equal(at_level(l, far, dims), at_level(l, near, dims));
    double separation = duet_large_poses_separation(&near[0], &near[1], 1, dims);
    double separation_off = duet_large_poses_separation(&off[0], &off[1], 1, dims);
    assert_memory_equal(&separation, &separation_off, sizeof separation);
}

TEST(hard_pairs_have_one_answer_wherever_they_are)
{
    rng r = rng_seed(test_seed());
    uint32_t n = 0;
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < 80; ++i) {
            uint32_t dims = 2 + (uint32_t)i % 2;
            hard_pair pair = c->make(&r, dims);
            if (!is_near(&pair))
                continue;
            ++n;
            check_moved(&pair, dims, &r);
        }
    assert_true(n > 800);
}

// Positions that a float near 0 has, too: then the oracle knows the answer.
TEST(far_pairs_collide_where_the_same_near_0_do)
{
    rng r = rng_seed(test_seed());
    uint32_t n_colliding = 0;
    for (int i = 0; i < 1000; ++i) {
        hard_pair pair = {{.half_extents = {0.5f, 0.25f, 0.125f}},
                          {.half_extents = {0.25f, 0.5f, 0.5f}}};
        for (int k = 0; k < 4; ++k) {
            pair.a.rotation[k] = (float)rng_normal(&r);
            pair.b.rotation[k] = i % 3 ? pair.a.rotation[k] : (float)rng_normal(&r);
        }
        for (int k = 0; k < 3; ++k)
            pair.b.centre[k] = 0x1p-22f * floorf((float)rng_between(&r, -0x1p22, 0x1p22));
        const double far[3] = {1e7, -9999999.75, 123456.5};
        duet_large_pose a = place(&pair.a, far), b = place(&pair.b, far);
        bool collide = oracle_collide(&pair.a, &pair.b, 3);
        n_colliding += collide;
        assert_int_equal(duet_large_poses_collide(&a, &b, 1, 3), collide);
    }
    assert_true(n_colliding > 100 && n_colliding < 900);
}

// The loss without: a coordinate is off by up to 2^-24 of itself, so that
// boxes 1e7 away that meet by 0.1 are told to be 0.5 apart.
TEST(a_float_coordinate_loses_what_cells_keep)
{
    const double at[2][3] = {{1e7 + 0.3, 0, 0}, {1e7 + 1.7, 0, 0}};
    duet_pose poses[2];
    duet_large_pose both[2];
    for (int i = 0; i < 2; ++i) {
        poses[i] = (duet_pose){{(float)at[i][0], 0, 0}, {0.75f, 1, 1}, {0, 0, 0, 1}};
        both[i].pose = poses[i];
        assert_true(origin_place(&both[i], at[i], 1));
        assert_true(fabs((double)poses[i].centre[0] - at[i][0]) <= 0x1p-24 * at[i][0]);
    }
    assert_true(duet_large_poses_collide(&both[0], &both[1], 1, 3));
    assert_true(fabs(duet_large_poses_separation(&both[0], &both[1], 1, 3) + 0.1) < 0x1p-24);
    assert_false(duet_poses_collide(&poses[0], &poses[1], 3));
    assert_true(duet_poses_separation(&poses[0], &poses[1], 3) == 0.5);
}

// ------------------------------------------------------------ worlds

static uint64_t step_hash(duet_world *world, const duet_plan *plan, duet_result *result)
{
    must(duet_world_set_plan(world, plan, ERR));
    must(duet_world_step(world, result, ERR));
    return duet_result_get_hash(result);
}

// One cloud of many sizes on every kind of search (tests/long has all of them).
static uint64_t check_cloud(const double at[3])
{
    static const struct {
        duet_mode mode;
        const char *variant;
    } ways[] = {
        {DUET_MODE_OWN, "gpu FUSED=1"}, {DUET_MODE_SLAB, "simd"}, {DUET_MODE_SHARED, "simd"}};
    rng r = rng_seed(test_seed());
    scatter_large(0, 300, at, 6, 20, true, &r);
    duet_scene *scene =
        kept(duet_scene_create(DUET_OBJECT_LARGE_POSES, large_poses, 300, 3, LARGE_EDGE, ERR));
    duet_world_def def = duet_scene_world_def(scene, default_pair());
    duet_world *world = create_world(&def);
    must(duet_world_set_scene(world, scene, ERR));
    const known_pairs truth = known_pairs_of_scene(scene, DUET_LEVEL_CERTIFIED);
    uint64_t candidates = 0;
    assert_true(truth.n > 300);
    for (int i = 0; i < 3; ++i) {
        duet_result result;
        def.plan.mode = ways[i].mode;
        set_variants(&def.plan, ways[i].variant);
        assert_true(step_hash(world, &def.plan, &result) == truth.hash);
        assert_true(i == 0 || result.candidates == candidates);
        candidates = result.candidates;
    }
    return truth.hash + candidates;
}

TEST(a_cloud_far_away_has_the_pairs_of_the_one_at_0)
{
    uint64_t here = check_cloud((double[]){0, 0, 0});
    assert_true(check_cloud((double[]){1e7, -1e7, 5e6}) == here);
}

// ------------------------------------------------------------ refusals

static void refuse_world(const duet_world_def *def, const char *words)
{
    must_fail(duet_world_create(def, ERR), DUET_STATUS_BAD_ARGUMENT, words);
}

TEST(a_world_says_what_origin_cells_do_not_go_with)
{
    duet_world_def def = large_def(3, true);
    def.origin_edge = 3;
    refuse_world(&def, "power of two");
    def.origin_edge = 1;
    strcpy(def.plan.variant_a, "paper");
    refuse_world(&def, "the paper's search knows no origin cells");
    strcpy(def.plan.variant_a, "auto");
    def.shape = DUET_SHAPE_BOUNDS;
    refuse_world(&def, "origin cells are for poses");
    def.shape = DUET_SHAPE_POSES;
    duet_world *world = create_world(&def);
    must_fail(duet_world_map_objects(world, DUET_OBJECT_POSES, 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "made for large poses, not for poses");
}

TEST(an_offset_that_is_not_settled_is_a_bad_object)
{
    const float wrong[] = {LARGE_EDGE, -LARGE_EDGE / 2, 0.05f, LARGE_EDGE * 0x1p-25f, NAN};
    duet_world_def def = large_def(3, true);
    duet_world *world = create_world(&def);
    for (int i = 0; i < 5; ++i) {
        duet_large_pose *to = must(duet_world_map_objects(world, DUET_OBJECT_LARGE_POSES, 2, ERR));
        to[0] = to[1] = (duet_large_pose){.pose = {{0}, {1, 1, 1}, {0, 0, 0, 1}}};
        to[1].pose.centre[i % 3] = wrong[i];
        duet_result result;
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 1 of 2");
    }
}

// A compiler stops at a poisoned word that is not skipped.
#define POISON "#pragma GCC poison ORIGIN_EDGE coord_along coords_of cells_between CELL_WORD\n"

static bool find_pairs(float origin, const char *variant, duet_error *err)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = "test_origin.kernels";
    duet_device_pair *poisoned = duet_device_pair_create(&def, err);
    duet_world_def world_def = large_def(3, true);
    world_def.pair = poisoned;
    world_def.origin_edge = origin;
    world_def.plan.share = 0;
    strcpy(world_def.plan.variant_b, variant);
    duet_world *world = duet_world_create(&world_def, err);
    duet_pose poses[2] = {large_poses[0].pose, large_poses[1].pose};
    duet_result result;
    bool ok =
        world &&
        (origin > 0 ? duet_world_set_objects(world, DUET_OBJECT_LARGE_POSES, large_poses, 2, err)
                    : duet_world_set_objects(world, DUET_OBJECT_POSES, poses, 2, err));
    ok = ok && duet_world_step(world, &result, err);
    duet_world_destroy(world);
    duet_device_pair_destroy(poisoned);
    return ok;
}

TEST(what_is_not_asked_for_is_not_compiled)
{
    rng r = rng_seed(test_seed());
    scatter_large(0, 2, (double[]){0, 0, 0}, 1, 1, true, &r);
    test_kernels_write("test_origin.kernels", "common.clh", POISON, "");
    must(find_pairs(0, "gpu FUSED=1", ERR));
    must(find_pairs(0, "simd", ERR));
    must_fail(find_pairs(LARGE_EDGE, "simd", ERR), DUET_STATUS_BUILD_FAILED, "");
}

// ------------------------------------------------------------ scenes

TEST(a_script_s_doubles_reach_their_cells)
{
    const char *text = "add(1e7 + 0.3, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1)\n"
                       "add(1e7 + 1.2, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1)\n"
                       "add{centre = {1e7 + 2.3, 0, 0}, half_extents = {0.5, 0.5, 0.5}}\n"
                       "return {origin = 'cell'}";
    duet_scene *scene = must(scene_from_text("far.lua", text, ERR));
    assert_true(duet_scene_get_info(scene)->origin_edge == 1);
    assert_true(test_poses(scene)[1].centre[0] == 10000001.0f);
    const duet_large_pose *p = duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES);
    assert_int_equal(p[1].cell[0], 10000001);
    assert_true(fabs(p[1].pose.centre[0] - 0.2) < 1e-7);
    assert_int_equal(known_pairs_of_scene(scene, DUET_LEVEL_CERTIFIED).n, 1);
}

static void refuse_scene(const char *name, const char *text, const char *setting, const char *words)
{
    duet_setting set = {"origin", setting};
    must_fail(scene_from_bytes(name, text, strlen(text), &set, setting != NULL, ERR), ANY_FAILURE,
              words);
}

TEST(a_scene_says_what_is_wrong_with_its_origin)
{
    refuse_scene("a.lua", "return {origin = 'cells'}", NULL,
                 "origin is 'cells'; expected \"cell\"");
    refuse_scene("a.lua", "return {origin = 'cell', origin_edge = 3}", NULL, "power of two");
    refuse_scene("a.lua", "return {origin = 'cell', origin_edge = {4, 2}}", NULL, "expected");
    refuse_scene("a.lua", "return {origin = 'cell', origin_edge = 'x'}", NULL, "expected");
    refuse_scene("a.lua", "return {origin = 'cell', origin_edge = 0/0}", NULL, "expected");
    refuse_scene("a.lua", "add(0, 0, 1, 1) return {origin = 'cell'}", NULL, "not by corners");
    refuse_scene("a.lua", "add(0, 3e9, 1, 1, 0) return {origin = 'cell'}", NULL, "object 0");
    refuse_scene("a.csv", "0 0 1 1 0\n", "yes", "only origin=cell and origin_edge can be set");
}

TEST(a_script_s_edge_is_the_scene_s)
{
    const char *text =
        "add(100, 0, 0, 1, 1, 1, 0, 0, 0, 1) return {origin = 'cell', origin_edge = 64}";
    duet_scene *scene = must(scene_from_text("edge.lua", text, ERR));
    assert_true(duet_scene_get_info(scene)->origin_edge == 64);
}

TEST(data_are_placed_where_that_is_asked_for)
{
    const char *text = "10000000.25 0 1 1 0\n10000000.75 0 1 1 0\n";
    const duet_setting settings[] = {{"origin", "cell"}, {"origin_edge", "0.5"}};
    duet_scene *scene = must(scene_from_bytes("far.csv", text, strlen(text), settings, 2, ERR));
    const duet_large_pose *p = duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES);
    assert_int_equal(p[1].cell[0] - p[0].cell[0], 1);
    assert_true(p[0].pose.centre[0] == 0.25f && p[1].pose.centre[0] == 0.25f);
}
