// SPDX-License-Identifier: MIT
// Every public call refuses NULL, and numbers that cannot be, with BAD_ARGUMENT or the
// neutral value that its header promises; the error may be NULL everywhere, and may hold an
// earlier failure, which gives way to the call's own. The list of calls is read from the headers
// and from the library, so that a call that is not here fails. A test is a group of calls.
#define _POSIX_C_SOURCE 200809L // popen
#include "support/task_files.h"
#include "support/test.h"

#include "runtime/duet_opencl.h"
#include "tuner/duet_tune.h"

#include "base/text.h"
#include "lua/duet_lua.h"
#include "profiles/duet_profiles.h"

#include <ctype.h>

// The rows are called with these where an argument is not the one in question.
static duet_device_pair *pair;
static duet_scene *scene;
static duet_world *world;
static duet_world *placed_world;
static duet_world *bounds_world;
static duet_world *apart_world;
static duet_motion *motion;
static duet_pair_query *test;
static duet_tree *tree;
static duet_ray_query *rays;
static duet_contact_query *touching;
static duet_box_query *boxes;
static duet_point_query *points;
static duet_sweep_query *sweeps;
static duet_online *online;
static duet_pose pose = {.half_extents = {1, 1, 1}, .rotation = {0, 0, 0, 1}};
static duet_large_pose placed;
static duet_bounds bounds;
static duet_result result;
static duet_pair *pairs;
static uint64_t n;

static void assert_failed(duet_status status, const duet_error *err, const char *said)
{
    if (err->status != status)
        fail_msg("%s: %s is %s: %s", test_running, said, duet_status_name(err->status), err->text);
    if (!err->text[0] || strchr(err->text, '\n'))
        fail_msg("%s: %s says '%s'", test_running, said, err->text);
}

static const duet_error earlier = {
    .cl_code = -1, .status = DUET_STATUS_DEVICE_FAILED, .text = "an earlier call failed"};
static text refused; // names of calls, each between blanks

// It failed twice: without an earlier failure, and with one.
static void assert_own(const duet_error *clean, const duet_error *used, const char *said)
{
    if (used->status != clean->status || used->cl_code != clean->cl_code ||
        strcmp(used->text, clean->text) != 0)
        fail_msg("%s: %s says '%s' after an earlier failure; expected '%s'", test_running, said,
                 used->text, clean->text);
    text_add(&refused, " %.*s ", (int)strcspn(said, "("), said);
}

// The call, which hands e on, fails with an error to fill, with one that is filled, and without.
#define FAILS(expected, call)                                     \
    do {                                                          \
        duet_error err_ = {0}, used_ = earlier;                   \
        duet_error *e = &err_;                                    \
        if (call)                                                 \
            fail_msg("%s: %s did not fail", test_running, #call); \
        assert_failed((expected), &err_, #call);                  \
        e = &used_;                                               \
        if (call)                                                 \
            fail_msg("%s: %s did not fail", test_running, #call); \
        assert_own(&err_, &used_, #call);                         \
        e = NULL;                                                 \
        if (call)                                                 \
            fail_msg("%s: %s did not fail", test_running, #call); \
    } while (0)
#define REFUSES(call) FAILS(DUET_STATUS_BAD_ARGUMENT, call)

// A call that succeeds leaves the error as it was.
#define TAKES(call)                                                 \
    do {                                                            \
        duet_error err_ = earlier;                                  \
        duet_error *e = &err_;                                      \
        if (!(call))                                                \
            fail_msg("%s: %s: %s", test_running, #call, err_.text); \
        assert_memory_equal(&err_, &earlier, sizeof earlier);       \
    } while (0)

// ------------------------------------------------------------ values and objects

TEST(names)
{
    assert_non_null(duet_version());
    assert_string_equal(duet_status_name((duet_status)-1), "UNKNOWN");
    assert_string_equal(duet_status_name((duet_status)1000), "UNKNOWN");
    assert_null(duet_mode_name((duet_mode)-1));
    assert_null(duet_mode_name((duet_mode)(DUET_MODE_DEFAULT + 1)));
    assert_null(duet_grade_name((duet_grade)-1));
    assert_null(duet_grade_name((duet_grade)99));
    assert_null(duet_effect_name(0));
    assert_null(duet_effect_name(3));
    assert_null(duet_effect_name(1u << 31));
}

TEST(strategies)
{
    assert_non_null(duet_strategy_get_name(0));
    assert_null(duet_strategy_get_name(100));
    assert_null(duet_strategy_get_name(UINT32_MAX));
    assert_null(duet_strategy_get_summary(100));
    assert_null(duet_strategy_get_summary(UINT32_MAX));
}

TEST(defaults)
{
    assert_true(duet_default_body().mass == 1.0f);
    assert_int_equal(duet_default_motion_def().dims, 3);
    assert_null(duet_game_motion_def(NULL, 3).pair);
    assert_int_equal(duet_default_pair_query_def().dims, 3);
    assert_int_equal(duet_default_world_def().dims, 3);
    assert_true(duet_default_tune_def().keep);
    assert_true(duet_default_online_def().most_extra > 0);
    assert_null(duet_default_device_pair_def().b);
    assert_true(duet_default_plan(NULL).share == DUET_SHARE_DEFAULT);
}

TEST(place)
{
    const double centre[3] = {0};
    const duet_transform still = {.rotation = {0}};
    duet_compact_transform compact;
    REFUSES(duet_compact_transform_set(NULL, &still, e));
    REFUSES(duet_compact_transform_set(&compact, NULL, e));
    REFUSES(duet_large_pose_set(NULL, centre, 1.0f, e));
    REFUSES(duet_large_pose_set(&placed, NULL, 1.0f, e));
    REFUSES(duet_large_pose_set(&placed, centre, 3.0f, e));
    REFUSES(duet_large_pose_set(&placed, centre, 0.0f, e));
    REFUSES(duet_large_pose_set(&placed, centre, NAN, e));
}

TEST(exact)
{
    assert_false(duet_poses_collide(NULL, &pose, 3));
    assert_false(duet_poses_collide(&pose, NULL, 3));
    assert_false(duet_poses_collide(&pose, &pose, 4));
    assert_true(duet_poses_collide(&pose, &pose, 3));
    assert_true(isnan(duet_poses_separation(NULL, &pose, 3)));
    assert_true(isnan(duet_poses_separation(&pose, NULL, 3)));
    assert_true(isnan(duet_poses_separation(&pose, &pose, 1)));
    assert_true(duet_poses_separation(&pose, &pose, 2) < 0);
}

TEST(exact_rounded)
{
    const duet_rounded_box rounded = {pose, 0.5f};
    assert_false(duet_rounded_boxes_collide(NULL, &rounded, 3));
    assert_false(duet_rounded_boxes_collide(&rounded, NULL, 3));
    assert_false(duet_rounded_boxes_collide(&rounded, &rounded, 4));
    assert_true(duet_rounded_boxes_collide(&rounded, &rounded, 3));
    assert_true(isnan(duet_rounded_boxes_separation(NULL, &rounded, 3)));
    assert_true(isnan(duet_rounded_boxes_separation(&rounded, NULL, 3)));
    assert_true(isnan(duet_rounded_boxes_separation(&rounded, &rounded, 1)));
    assert_true(duet_rounded_boxes_separation(&rounded, &rounded, 2) < -1);
}

TEST(exact_placed)
{
    duet_large_pose p = {.pose = pose};
    assert_false(duet_large_poses_collide(NULL, &p, 1.0f, 3));
    assert_false(duet_large_poses_collide(&p, NULL, 1.0f, 3));
    assert_false(duet_large_poses_collide(&p, &p, 3.0f, 3));
    assert_false(duet_large_poses_collide(&p, &p, 1.0f, 0));
    assert_true(duet_large_poses_collide(&p, &p, 1.0f, 3));
    assert_true(isnan(duet_large_poses_separation(NULL, &p, 1.0f, 3)));
    assert_true(isnan(duet_large_poses_separation(&p, NULL, 1.0f, 3)));
    assert_true(isnan(duet_large_poses_separation(&p, &p, 0.0f, 3)));
    assert_true(isnan(duet_large_poses_separation(&p, &p, 1.0f, UINT32_MAX)));
}

TEST(levels)
{
    duet_level level = DUET_LEVEL_AABB;
    assert_null(duet_level_get_info((duet_level)-1));
    assert_null(duet_level_get_info((duet_level)DUET_LEVELS));
    assert_false(duet_level_from_name(NULL, &level));
    assert_false(duet_level_from_name("certified", NULL));
    assert_false(duet_level_from_name("", &level));
    assert_int_equal(level, DUET_LEVEL_AABB);
    assert_false(duet_level_covers((duet_level)DUET_LEVELS, DUET_LEVEL_AABB));
    assert_false(duet_level_covers(DUET_LEVEL_AABB, (duet_level)-7));
}

TEST(results)
{
    assert_true(duet_pairs_hash(NULL, 5) == 0);
    assert_true(duet_result_get_hash(NULL) == 0);
    duet_pair none = duet_result_get_pair(NULL, 0);
    assert_int_equal(none.a | none.b, 0);
    none = duet_result_get_pair(&result, result.pairs);
    assert_int_equal(none.a | none.b, 0);
    none = duet_result_get_pair(&result, UINT64_MAX);
    assert_int_equal(none.a | none.b, 0);
}

TEST(memory)
{
    duet_free(NULL);
}

// ------------------------------------------------------------ devices and scenes

TEST(device_lists)
{
    duet_device_list *list = duet_device_list_create(NULL);
    assert_non_null(list);
    assert_null(duet_device_list_get_info(NULL, 0));
    assert_null(duet_device_list_get_info(list, duet_device_list_get_count(list)));
    assert_null(duet_device_list_get_info(list, UINT32_MAX));
    assert_int_equal(duet_device_list_get_count(NULL), 0);
    assert_null(duet_device_info_get_quirk(NULL, 0));
    assert_null(duet_device_list_get_absent(NULL, 0));
    assert_null(duet_device_list_get_absent(list, UINT32_MAX));
    duet_device_list_destroy(list);
    duet_device_list_destroy(NULL);
}

TEST(device_pairs)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    REFUSES(duet_device_pair_create(NULL, e));
    def.a = NULL;
    def.b = "pocl:0";
    REFUSES(duet_device_pair_create(&def, e));
    REFUSES(duet_device_pair_open("cpu,cpu,cpu", e));
    REFUSES(duet_device_pair_check_cache(NULL, e));
    def = (duet_device_pair_def){0};
    REFUSES(duet_device_pair_create(&def, e));
    assert_null(duet_device_pair_get_info(NULL, 0));
    assert_false(duet_device_pair_is_one(NULL));
    assert_null(duet_device_pair_get_info(pair, 2));
    assert_null(duet_device_pair_get_info(pair, -1));
    duet_device_pair_destroy(NULL);
}

TEST(load_scene)
{
    const duet_setting settings[] = {{NULL, "1"}, {"n", NULL}};
    REFUSES(duet_scene_load(NULL, NULL, 0, e));
    REFUSES(duet_scene_load("scene.lua", NULL, 1, e));
    REFUSES(duet_scene_load("scene.lua", settings, 1, e));
    REFUSES(duet_scene_load("scene.lua", settings + 1, 1, e));
    REFUSES(duet_scene_load_pairs(NULL, e));
}

TEST(copy_scene)
{
    REFUSES(duet_scene_create(DUET_OBJECT_POSES, NULL, 1, 3, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 4, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_BOUNDS, NULL, 1, 3, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_BOUNDS, &bounds, 1, 1, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_ROUNDED_BOXES, NULL, 1, 3, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_SPHERES, NULL, 1, 3, 0, e));
    REFUSES(duet_scene_create(DUET_OBJECT_SPHERES, &pose, 1, 3, 1.0f, e));
    REFUSES(duet_scene_create(DUET_OBJECT_LARGE_POSES, NULL, 1, 3, 1.0f, e));
    REFUSES(duet_scene_create(DUET_OBJECT_LARGE_POSES, NULL, UINT32_MAX, 3, 1.0f, e));
    REFUSES(duet_scene_create(DUET_OBJECT_LARGE_POSES, &placed, 0, 0, 1.0f, e));
    REFUSES(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 3, 1.0f, e));
    REFUSES(duet_scene_create(DUET_OBJECT_SIZES, &pose, 1, 3, 0, e));
    REFUSES(duet_scene_create((duet_object_kind)9, &pose, 1, 3, 0, e));
    duet_scene *empty = duet_scene_create(DUET_OBJECT_POSES, NULL, 0, 3, 0, NULL);
    assert_non_null(empty);
    duet_scene_destroy(empty);
}

TEST(read_scene)
{
    assert_null(duet_scene_get_info(NULL));
    assert_null(duet_scene_get_objects(NULL, DUET_OBJECT_POSES));
    assert_null(duet_scene_get_objects(NULL, DUET_OBJECT_BOUNDS));
    assert_null(duet_scene_get_objects(NULL, DUET_OBJECT_LARGE_POSES));
    assert_null(duet_scene_get_objects(scene, DUET_OBJECT_SIZES));
    assert_null(duet_scene_get_objects(scene, (duet_object_kind)9));
    assert_null(duet_scene_get_bodies(NULL));
    duet_world_def def = duet_scene_world_def(NULL, pair);
    assert_true(def.pair == pair && def.dims == 3);
    duet_motion_def moving = duet_scene_motion_def(NULL, pair);
    assert_true(moving.pair == pair && moving.dims == 3);
    assert_null(duet_scene_world_def(scene, NULL).pair);
    assert_null(duet_scene_motion_def(scene, NULL).pair);
    duet_scene_destroy(NULL);
}

// ------------------------------------------------------------ worlds

TEST(create_world)
{
    duet_world_def def = duet_default_world_def();
    REFUSES(duet_world_create(NULL, e));
    REFUSES(duet_world_create(&def, e));
    def.pair = pair;
    def.dims = 0;
    REFUSES(duet_world_create(&def, e));
    def = duet_default_world_def();
    def.pair = pair;
    memset(def.plan.variant_a, 'x', sizeof def.plan.variant_a);
    REFUSES(duet_world_create(&def, e));
    def = (duet_world_def){.pair = pair, .dims = 3};
    REFUSES(duet_world_create(&def, e));
    duet_world_destroy(NULL);
}

TEST(set_objects)
{
    REFUSES(duet_world_set_objects(NULL, DUET_OBJECT_POSES, &pose, 1, e));
    REFUSES(duet_world_set_objects(world, DUET_OBJECT_POSES, NULL, 5, e));
    REFUSES(duet_world_set_objects(apart_world, DUET_OBJECT_POSES, NULL, 5, e));
    REFUSES(duet_world_set_objects(bounds_world, DUET_OBJECT_POSES, &pose, 1, e));
    REFUSES(duet_world_set_objects(NULL, DUET_OBJECT_BOUNDS, &bounds, 1, e));
    REFUSES(duet_world_set_objects(bounds_world, DUET_OBJECT_BOUNDS, NULL, 5, e));
    REFUSES(duet_world_set_objects(NULL, DUET_OBJECT_LARGE_POSES, &placed, 1, e));
    REFUSES(duet_world_set_objects(placed_world, DUET_OBJECT_LARGE_POSES, NULL, 5, e));
    REFUSES(duet_world_set_objects(world, (duet_object_kind)9, &pose, 1, e));
    REFUSES(duet_world_set_scene(NULL, scene, e));
    REFUSES(duet_world_set_scene(world, NULL, e));
    TAKES(duet_world_set_objects(bounds_world, DUET_OBJECT_BOUNDS, NULL, 0, e));
    TAKES(duet_world_set_objects(placed_world, DUET_OBJECT_LARGE_POSES, NULL, 0, e));
}

TEST(map_objects)
{
    REFUSES(duet_world_map_objects(NULL, DUET_OBJECT_POSES, 1, e));
    REFUSES(duet_world_map_objects(bounds_world, DUET_OBJECT_POSES, 1, e));
    REFUSES(duet_world_map_objects(NULL, DUET_OBJECT_BOUNDS, 1, e));
    REFUSES(duet_world_map_objects(world, DUET_OBJECT_BOUNDS, 1, e));
    REFUSES(duet_world_map_objects(NULL, DUET_OBJECT_LARGE_POSES, 1, e));
    REFUSES(duet_world_map_objects(world, DUET_OBJECT_LARGE_POSES, 1, e));
    REFUSES(duet_world_map_objects(NULL, DUET_OBJECT_TRANSFORMS, 1, e));
    REFUSES(duet_world_map_objects(world, DUET_OBJECT_TRANSFORMS, 1, e));
    REFUSES(duet_world_map_objects(NULL, DUET_OBJECT_SIZES, 1, e));
    REFUSES(duet_world_map_objects(world, DUET_OBJECT_SIZES, 1, e));
    assert_null(duet_world_map_objects(world, DUET_OBJECT_POSES, UINT32_MAX, NULL));
}

TEST(plan_world)
{
    duet_plan plan = *duet_world_get_plan(world);
    REFUSES(duet_world_set_plan(NULL, &plan, e));
    REFUSES(duet_world_set_plan(world, NULL, e));
    plan.share = DUET_SHARE_ONE + 1;
    REFUSES(duet_world_set_plan(world, &plan, e));
    plan = *duet_world_get_plan(world);
    plan.mode = (duet_mode)7;
    REFUSES(duet_world_set_plan(world, &plan, e));
    plan = *duet_world_get_plan(world);
    memset(plan.variant_b, 'x', sizeof plan.variant_b);
    REFUSES(duet_world_set_plan(world, &plan, e));
    assert_null(duet_world_get_plan(NULL));
    REFUSES(duet_world_set_level(NULL, DUET_LEVEL_AABB, e));
    REFUSES(duet_world_set_level(world, (duet_level)99, e));
    assert_int_equal(duet_world_get_level(NULL), DUET_LEVEL_CERTIFIED);
}

TEST(order_world)
{
    uint32_t *order = NULL, n_ordered = 0;
    REFUSES(duet_world_order(NULL, &order, &n_ordered, e));
    REFUSES(duet_world_order(world, NULL, &n_ordered, e));
    REFUSES(duet_world_order(world, &order, NULL, e));
    assert_null(order);
}

TEST(load_profile)
{
    duet_profile profile;
    char *why = NULL;
    REFUSES(duet_world_load_profile(NULL, NULL, &profile, e));
    REFUSES(duet_world_load_profile(world, NULL, NULL, e));
    REFUSES(duet_world_explain_profile(NULL, NULL, &why, e));
    REFUSES(duet_world_explain_profile(world, NULL, NULL, e));
}

TEST(step_world)
{
    REFUSES(duet_world_step(NULL, &result, e));
    REFUSES(duet_world_step(world, NULL, e));
    REFUSES(duet_world_step_begin(NULL, e));
    REFUSES(duet_world_step_end(NULL, &result, e));
    REFUSES(duet_world_step_end(world, &result, e));
    TAKES(duet_world_step_begin(world, e));
    REFUSES(duet_world_step_end(world, NULL, e));
    TAKES(duet_world_step_end(world, &result, e));
}

TEST(own_opencl)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    duet_pair_buffers buffers;
    cl_event done = NULL;
    REFUSES(duet_device_pair_create_on_queues(NULL, NULL, NULL, e));
    REFUSES(duet_device_pair_create_on_queues(&def, NULL, NULL, e));
    REFUSES(duet_world_set_objects_buffer(NULL, DUET_OBJECT_POSES, NULL, 1, 0, NULL, e));
    REFUSES(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, NULL, 1, 0, NULL, e));
    REFUSES(duet_world_set_objects_buffer(world, (duet_object_kind)99, NULL, 1, 0, NULL, e));
    REFUSES(duet_world_leave_pairs(NULL, 0, NULL, NULL, e));
    REFUSES(duet_world_leave_pairs(world, -1, NULL, NULL, e));
    REFUSES(duet_world_bring_pairs(NULL, e));
    REFUSES(duet_world_get_pair_buffers(NULL, &buffers, e));
    REFUSES(duet_world_get_pair_buffers(world, NULL, e));
    REFUSES(duet_world_get_pair_buffers(world, &buffers, e));
    REFUSES(duet_world_step_begin_event(NULL, &done, e));
    REFUSES(duet_world_step_begin_event(world, NULL, e));
    REFUSES(duet_world_step_begin_event(world, &done, e));
    REFUSES(duet_motion_copy_states(NULL, DUET_STATE_CENTRES, NULL, 0, NULL, NULL, e));
    REFUSES(duet_motion_copy_states(motion, DUET_STATE_CENTRES, NULL, 0, NULL, NULL, e));
    REFUSES(duet_motion_copy_states(motion, (duet_state_part)-1, NULL, 0, NULL, NULL, e));
}

TEST(map_motion)
{
    REFUSES(duet_motion_map_states(NULL, DUET_STATE_CENTRES, DUET_MAP_READ, 0, 1, e));
    REFUSES(duet_motion_map_states(motion, (duet_state_part)-1, DUET_MAP_READ, 0, 1, e));
    REFUSES(duet_motion_map_states(motion, DUET_STATE_CENTRES, (duet_map_access)-1, 0, 1, e));
    REFUSES(duet_motion_map_states(motion, DUET_STATE_CENTRES, DUET_MAP_READ, UINT32_MAX, 2, e));
    REFUSES(duet_motion_unmap_states(NULL, DUET_STATE_CENTRES, e));
    REFUSES(duet_motion_unmap_states(motion, DUET_STATE_CENTRES, e));
    REFUSES(duet_motion_unmap_states(motion, (duet_state_part)99, e));
    assert_null(duet_state_part_name((duet_state_part)-1));
}

TEST(query_pairs)
{
    duet_pair_query_def def = duet_default_pair_query_def();
    duet_pair_query_result found;
    duet_pose two[2] = {pose, pose};
    uint8_t answer;
    REFUSES(duet_pair_query_create(NULL, e));
    REFUSES(duet_pair_query_create(&def, e));
    def.pair = pair;
    def.share = DUET_SHARE_ONE + 1;
    REFUSES(duet_pair_query_create(&def, e));
    REFUSES(duet_pair_query_run(NULL, two, 1, &answer, NULL, &found, e));
    REFUSES(duet_pair_query_run(test, NULL, 1, &answer, NULL, &found, e));
    REFUSES(duet_pair_query_run(test, two, 1, NULL, NULL, &found, e));
    REFUSES(duet_pair_query_run(test, two, 1, &answer, NULL, NULL, e));
    TAKES(duet_pair_query_run(test, NULL, 0, NULL, NULL, &found, e));
    duet_pair_query_destroy(NULL);
}

TEST(fill_tree)
{
    duet_tree_def def = duet_default_tree_def();
    REFUSES(duet_tree_create(NULL, e));
    REFUSES(duet_tree_create(&def, e));
    def.pair = pair;
    def.share = DUET_SHARE_ONE + 1;
    REFUSES(duet_tree_create(&def, e));
    def.share = 0;
    def.dims = 4;
    REFUSES(duet_tree_create(&def, e));
    def.dims = 3;
    def.shape = (duet_shape)DUET_SHAPES;
    REFUSES(duet_tree_create(&def, e));
    REFUSES(duet_tree_set_objects(NULL, DUET_OBJECT_POSES, &pose, 1, e));
    REFUSES(duet_tree_set_objects(tree, DUET_OBJECT_POSES, NULL, 1, e));
    REFUSES(duet_tree_set_objects(tree, DUET_OBJECT_BOUNDS, &bounds, 1, e));
    REFUSES(duet_tree_set_objects(tree, DUET_OBJECT_SIZES, &pose, 1, e));
    TAKES(duet_tree_set_objects(tree, DUET_OBJECT_POSES, NULL, 0, e));
    REFUSES(duet_tree_set_share(NULL, 0, e));
    REFUSES(duet_tree_set_share(tree, DUET_SHARE_ONE + 1, e));
    TAKES(duet_tree_set_share(tree, 0, e));
    duet_profile profile;
    REFUSES(duet_tree_load_profile(NULL, "boxes", 1, NULL, &profile, e));
    REFUSES(duet_tree_load_profile(tree, NULL, 1, NULL, &profile, e));
    REFUSES(duet_tree_load_profile(tree, "boxes", 1, NULL, NULL, e));
    REFUSES(duet_tree_load_profile(tree, "spheres", 1, NULL, &profile, e));
    REFUSES(duet_tree_load_profile(tree, "boxes", 0, NULL, &profile, e));
    assert_null(duet_motion_tree_def(NULL).pair);
    REFUSES(duet_tree_set_filters(NULL, &(duet_filter){1, 1}, 1, e));
    REFUSES(duet_tree_set_filters(tree, NULL, 1, e));
    REFUSES(duet_tree_set_filters(tree, &(duet_filter){1, 1}, 1, e)); // the tree has no objects
    TAKES(duet_tree_set_filters(tree, NULL, 0, e));
    REFUSES(duet_tree_set_motion(NULL, motion, e));
    REFUSES(duet_tree_set_motion(tree, NULL, e));
    REFUSES(duet_tree_set_heights(NULL, NULL, e));
    REFUSES(duet_tree_set_heights(tree, &(duet_heights){.nx = 1}, e));
    TAKES(duet_tree_set_heights(tree, NULL, e));
    REFUSES(duet_tree_set_mesh(NULL, NULL, e));
    REFUSES(duet_tree_set_mesh(tree, &(duet_mesh){.n_vertices = 1}, e));
    TAKES(duet_tree_set_mesh(tree, NULL, e));
    duet_tree_destroy(NULL);
}

TEST(cast_rays)
{
    duet_ray_query_def def = duet_default_ray_query_def();
    duet_ray_query_result found;
    const duet_ray ray = {{0}, {1, 0, 0}, 1};
    assert_null(duet_query_wants_name((duet_query_wants)3));
    REFUSES(duet_ray_query_create(NULL, e));
    REFUSES(duet_ray_query_create(&def, e));
    def.tree = tree;
    def.wants = (duet_query_wants)3;
    REFUSES(duet_ray_query_create(&def, e));
    REFUSES(duet_ray_query_run(NULL, &ray, 1, &found, e));
    REFUSES(duet_ray_query_run(rays, NULL, 1, &found, e));
    REFUSES(duet_ray_query_run(rays, &ray, 1, NULL, e));
    TAKES(duet_ray_query_run(rays, NULL, 0, &found, e));
    const duet_large_ray large = {ray, {0}};
    REFUSES(duet_ray_query_run_large(NULL, &large, 1, &found, e));
    REFUSES(duet_ray_query_run_large(rays, &large, 1, &found, e)); // the tree has no origin cells
    REFUSES(duet_ray_query_run_large(rays, &large, 1, NULL, e));
    duet_ray_query_destroy(NULL);
}

TEST(find_contacts)
{
    duet_contact_query_def def = duet_default_contact_query_def();
    duet_contact_query_result found;
    const duet_pose two[2] = {pose, pose};
    const duet_pair first = {0, 1};
    const duet_span one[2] = {{&first, 1}, {0}}, none[2] = {{0}}, lost[2] = {{NULL, 1}, {0}};
    REFUSES(duet_contact_query_create(NULL, e));
    REFUSES(duet_contact_query_create(&def, e));
    def.pair = pair;
    def.share = DUET_SHARE_ONE + 1;
    REFUSES(duet_contact_query_create(&def, e));
    def.share = 0;
    def.shape = DUET_SHAPE_BOUNDS;
    REFUSES(duet_contact_query_create(&def, e));
    def.shape = DUET_SHAPES;
    REFUSES(duet_contact_query_create(&def, e));
    def.shape = DUET_SHAPE_POSES;
    def.margin = -1;
    REFUSES(duet_contact_query_create(&def, e));
    REFUSES(duet_contact_query_run(NULL, DUET_OBJECT_POSES, two, 2, one, &found, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_POSES, NULL, 2, one, &found, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_POSES, two, 2, NULL, &found, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_POSES, two, 2, lost, &found, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_POSES, two, 1, one, &found, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_POSES, two, 2, one, NULL, e));
    REFUSES(duet_contact_query_run(touching, DUET_OBJECT_SPHERES, two, 2, one, &found, e));
    TAKES(duet_contact_query_run(touching, DUET_OBJECT_POSES, NULL, 0, none, &found, e));
    duet_contact_query_destroy(NULL);
}

TEST(read_some)
{
    const uint32_t id = 0, none = 2;
    duet_state found;
    duet_moved moved;
    REFUSES(duet_motion_get_states_of(NULL, &id, 1, &found, e));
    REFUSES(duet_motion_get_states_of(motion, NULL, 1, &found, e));
    REFUSES(duet_motion_get_states_of(motion, &id, 1, NULL, e));
    REFUSES(duet_motion_get_states_of(motion, &none, 1, &found, e));
    TAKES(duet_motion_get_states_of(motion, NULL, 0, NULL, e));
    REFUSES(duet_motion_get_moved(NULL, &moved, e));
    REFUSES(duet_motion_get_moved(motion, NULL, e));
    assert_true(duet_state_between(NULL, &found, 0.5).rotation[3] == 1);
    assert_true(duet_state_between(&found, NULL, 0.5).rotation[3] == 1);
}

TEST(compare_pairs)
{
    duet_pair_delta_result found;
    const duet_pair first = {0, 1};
    const duet_span one[2] = {{&first, 1}, {0}}, lost[2] = {{NULL, 1}, {0}};
    duet_pair_delta *delta = duet_pair_delta_create(NULL);
    REFUSES(duet_pair_delta_update(NULL, one, &found, e));
    REFUSES(duet_pair_delta_update(delta, NULL, &found, e));
    REFUSES(duet_pair_delta_update(delta, lost, &found, e));
    REFUSES(duet_pair_delta_update(delta, one, NULL, e));
    TAKES(duet_pair_delta_update(delta, one, &found, e));
    duet_pair_delta_destroy(delta);
    duet_pair_delta_destroy(NULL);
}

TEST(join_boxes)
{
    duet_box_query_def def = duet_default_box_query_def();
    duet_box_query_result found;
    REFUSES(duet_box_query_create(NULL, e));
    REFUSES(duet_box_query_create(&def, e));
    def.tree = tree;
    def.level = (duet_level)DUET_LEVELS;
    REFUSES(duet_box_query_create(&def, e));
    REFUSES(duet_box_query_run(NULL, DUET_OBJECT_POSES, &pose, 1, &found, e));
    REFUSES(duet_box_query_run(boxes, DUET_OBJECT_BOUNDS, &bounds, 1, &found, e));
    REFUSES(duet_box_query_run(boxes, DUET_OBJECT_POSES, NULL, 1, &found, e));
    REFUSES(duet_box_query_run(boxes, DUET_OBJECT_POSES, &pose, 1, NULL, e));
    TAKES(duet_box_query_run(boxes, DUET_OBJECT_POSES, &pose, 1, &found, e));
    REFUSES(duet_box_query_run_itself(NULL, NULL, 0, &found, e));
    REFUSES(duet_box_query_run_itself(boxes, NULL, 0, NULL, e));
    TAKES(duet_box_query_run_itself(boxes, NULL, 0, &found, e));
    REFUSES(duet_box_query_run_itself(boxes, &(duet_filter){1, 1}, 2, &found, e));
    duet_box_query_destroy(NULL);
}

TEST(ask_about_points)
{
    duet_point_query_def def = duet_default_point_query_def();
    duet_point_query_result found;
    const duet_point point = {{0}};
    REFUSES(duet_point_query_create(NULL, e));
    REFUSES(duet_point_query_create(&def, e));
    def.tree = tree;
    def.nearest = DUET_MOST_NEAREST + 1;
    REFUSES(duet_point_query_create(&def, e));
    REFUSES(duet_point_query_run(NULL, &point, 1, &found, e));
    REFUSES(duet_point_query_run(points, NULL, 1, &found, e));
    REFUSES(duet_point_query_run(points, &point, 1, NULL, e));
    TAKES(duet_point_query_run(points, &point, 1, &found, e));
    const duet_large_point large = {point, {0}};
    REFUSES(duet_point_query_run_large(NULL, &large, 1, &found, e));
    REFUSES(duet_point_query_run_large(points, &large, 1, &found, e)); // no origin cells
    REFUSES(duet_point_query_run_large(points, &large, 1, NULL, e));
    duet_point_query_destroy(NULL);
}

TEST(move_boxes)
{
    duet_sweep_query_def def = duet_default_sweep_query_def();
    duet_sweep_query_result found;
    const duet_sweep sweep = {pose, {1, 0, 0}, 1};
    const duet_bounds_sweep bounds_sweep = {bounds, {1, 0, 0}, 1};
    REFUSES(duet_sweep_query_create(NULL, e));
    REFUSES(duet_sweep_query_create(&def, e));
    def.tree = tree;
    def.wants = (duet_query_wants)3;
    REFUSES(duet_sweep_query_create(&def, e));
    REFUSES(duet_sweep_query_run(NULL, DUET_OBJECT_POSES, &sweep, 1, &found, e));
    REFUSES(duet_sweep_query_run(sweeps, DUET_OBJECT_BOUNDS, &bounds_sweep, 1, &found, e));
    REFUSES(duet_sweep_query_run(sweeps, DUET_OBJECT_POSES, NULL, 1, &found, e));
    REFUSES(duet_sweep_query_run(sweeps, DUET_OBJECT_POSES, &sweep, 1, NULL, e));
    TAKES(duet_sweep_query_run(sweeps, DUET_OBJECT_POSES, &sweep, 1, &found, e));
    duet_sweep_query_destroy(NULL);
}

TEST(references)
{
    REFUSES(duet_reference(NULL, DUET_LEVEL_CERTIFIED, &pairs, &n, e));
    REFUSES(duet_reference(scene, DUET_LEVEL_CERTIFIED, NULL, &n, e));
    REFUSES(duet_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, NULL, e));
    REFUSES(duet_reference(NULL, DUET_LEVEL_AABB, &pairs, &n, e));
    REFUSES(duet_reference(scene, (duet_level)DUET_LEVELS, &pairs, &n, e));
    REFUSES(duet_reference(scene, DUET_LEVEL_AABB, NULL, &n, e));
    REFUSES(duet_reference(scene, DUET_LEVEL_AABB, &pairs, NULL, e));
}

// ------------------------------------------------------------ motions

TEST(create_motion)
{
    duet_motion_def def = duet_default_motion_def();
    REFUSES(duet_motion_create(NULL, &pose, NULL, 1, e));
    REFUSES(duet_motion_create(&def, &pose, NULL, 1, e));
    def.pair = pair;
    REFUSES(duet_motion_create(&def, NULL, NULL, 1, e));
    must_fail(duet_motion_create(&def, &pose, NULL, UINT32_MAX, ERR), DUET_STATUS_TOO_MANY, "");
    REFUSES(duet_motion_create_from_scene(NULL, scene, NULL, e));
    REFUSES(duet_motion_create_from_scene(&def, NULL, NULL, e));
    duet_motion_destroy(NULL);
}

TEST(read_motion)
{
    duet_rounded_box round;
    duet_state states[2];
    uint8_t asleep;
    duet_energy energy;
    duet_contact *contacts;
    uint64_t hash;
    REFUSES(duet_motion_get_states(NULL, states, e));
    REFUSES(duet_motion_get_states(motion, NULL, e));
    REFUSES(duet_motion_get_poses(NULL, &pose, e));
    REFUSES(duet_motion_get_poses(motion, NULL, e));
    REFUSES(duet_motion_get_rounded_boxes(NULL, &round, e));
    REFUSES(duet_motion_get_rounded_boxes(motion, NULL, e));
    REFUSES(duet_motion_get_asleep(NULL, &asleep, e));
    REFUSES(duet_motion_get_asleep(motion, NULL, e));
    REFUSES(duet_motion_get_hash(NULL, &hash, e));
    REFUSES(duet_motion_get_hash(motion, NULL, e));
    REFUSES(duet_motion_get_energy(NULL, &energy, e));
    REFUSES(duet_motion_get_energy(motion, NULL, e));
    REFUSES(duet_motion_get_contacts(NULL, &contacts, &n, e));
    REFUSES(duet_motion_get_contacts(motion, NULL, &n, e));
    REFUSES(duet_motion_get_contacts(motion, &contacts, NULL, e));
    assert_int_equal(duet_motion_get_effects(NULL), 0);
    assert_null(duet_motion_get_plan(NULL));
    assert_null(duet_motion_get_plan(motion)); // it seeks no pairs
    assert_int_equal(duet_motion_get_count(NULL), 0);
    assert_int_equal(duet_motion_get_step(NULL), 0);
}

TEST(plan_motion)
{
    duet_plan plan = duet_default_plan(pair);
    duet_profile profile;
    REFUSES(duet_motion_set_plan(NULL, &plan, e));
    REFUSES(duet_motion_set_plan(motion, NULL, e));
    TAKES(duet_motion_set_plan(motion, &plan, e));
    strcpy(plan.variant_b, "auto bodies.GRAVITY=1");
    REFUSES(duet_motion_set_plan(motion, &plan, e));
    REFUSES(duet_motion_load_profile(NULL, NULL, &profile, e));
    REFUSES(duet_motion_load_profile(motion, NULL, NULL, e));
}

TEST(advance_motion)
{
    duet_motion_result moved;
    REFUSES(duet_motion_advance(NULL, &moved, e));
    REFUSES(duet_motion_advance(motion, NULL, e));
    REFUSES(duet_motion_advance_begin(NULL, e));
    REFUSES(duet_motion_advance_end(NULL, &moved, e));
    REFUSES(duet_motion_advance_end(motion, &moved, e));
    TAKES(duet_motion_advance_begin(motion, e));
    REFUSES(duet_motion_advance_end(motion, NULL, e));
    TAKES(duet_motion_advance_end(motion, &moved, e));
}

TEST(keep_motion)
{
    REFUSES(duet_motion_save(NULL, "file", e));
    REFUSES(duet_motion_save(motion, NULL, e));
    REFUSES(duet_motion_load(NULL, "file", e));
    REFUSES(duet_motion_load(motion, NULL, e));
}

TEST(replay_commands)
{
    duet_motion_result step;
    REFUSES(duet_motion_record(NULL, e));
    REFUSES(duet_motion_save_recording(NULL, "file", e));
    REFUSES(duet_motion_save_recording(motion, NULL, e));
    REFUSES(duet_replay_advance(NULL, motion, &step, e));
    REFUSES(duet_replay_create(NULL, e));
    assert_int_equal(duet_replay_get_info(NULL).steps, 0);
    duet_replay_destroy(NULL);
}

TEST(command_motion)
{
    const duet_body_list all = {.n = 1};
    const duet_body body = duet_default_body();
    const duet_transform transform = {.rotation = {0, 0, 0, 1}};
    const duet_force force = {0};
    const duet_impulse impulse = {0};
    uint64_t ids[1] = {0};
    REFUSES(duet_motion_add_bodies(NULL, &pose, NULL, 1, ids, e));
    REFUSES(duet_motion_add_bodies(motion, NULL, NULL, 1, ids, e));
    REFUSES(duet_motion_remove_bodies(NULL, all, e));
    REFUSES(duet_motion_disable_bodies(NULL, all, e));
    REFUSES(duet_motion_enable_bodies(NULL, all, e));
    REFUSES(duet_motion_wake_bodies(NULL, all, e));
    REFUSES(duet_motion_sleep_bodies(NULL, all, e));
    REFUSES(duet_motion_get_ids(NULL, 0, 1, ids, e));
    REFUSES(duet_motion_get_ids(motion, 0, 1, NULL, e));
    REFUSES(duet_motion_get_ids(motion, 1, UINT32_MAX, ids, e));
    assert_false(duet_motion_has_body(NULL, 0));
    REFUSES(duet_motion_set_user_data(NULL, all, ids, e));
    REFUSES(duet_motion_set_user_data(motion, all, NULL, e));
    REFUSES(duet_motion_get_user_data(NULL, all, ids, e));
    REFUSES(duet_motion_get_user_data(motion, all, NULL, e));
    REFUSES(duet_motion_set_bodies(NULL, all, DUET_BODY_MASS, &body, e));
    REFUSES(duet_motion_set_bodies(motion, all, DUET_BODY_MASS, NULL, e));
    REFUSES(duet_motion_set_bodies(motion, all, UINT32_MAX, &body, e));
    assert_null(duet_body_field_name(3));
    REFUSES(duet_motion_set_poses(NULL, all, &pose, e));
    REFUSES(duet_motion_set_poses(motion, all, NULL, e));
    REFUSES(duet_motion_set_targets(NULL, all, &transform, e));
    REFUSES(duet_motion_set_targets(motion, all, NULL, e));
    REFUSES(duet_motion_set_def(NULL, duet_motion_get_def(motion), e));
    REFUSES(duet_motion_set_def(motion, NULL, e));
    assert_null(duet_motion_get_def(NULL));
    REFUSES(duet_motion_apply_forces(NULL, all, &force, e));
    REFUSES(duet_motion_apply_forces(motion, all, NULL, e));
    REFUSES(duet_motion_apply_impulses(NULL, all, &impulse, e));
    REFUSES(duet_motion_apply_impulses(motion, all, NULL, e));
}

TEST(explain_motion)
{
    duet_effect_info info;
    assert_false(duet_motion_explain(NULL, 0, &info));
    assert_false(duet_motion_explain(motion, 0, NULL));
    assert_false(duet_motion_explain(motion, UINT32_MAX, &info));
    duet_substep_info substeps;
    assert_false(duet_motion_explain_substeps(NULL, &substeps));
    assert_false(duet_motion_explain_substeps(motion, NULL));
}

// ------------------------------------------------------------ tasks

static duet_task *make_task(void)
{
    duet_task_def def = duet_default_task_def();
    task_files_write(".", "twice", "int m\nconst int *x\nint *y\n", "y[i] = m * x[i];");
    test_write_file("twice.task.lua",
                    "return { kernel = 'twice', items = 4, args = { m = 2, x = { 'int', 4, access "
                    "= 'slice' }, y = { 'int', 4, access = 'out slice' } } }");
    def.pair = pair;
    def.path = "twice.task.lua";
    return must(duet_task_create(&def, ERR));
}

// What a program says in the place of a task file.
static void describe_task(void)
{
    const duet_setting nameless = {NULL, "1"}, without_value = {"n", NULL};
    const duet_task_arg_def y = {.name = "y", .type = "int", .elements = 4, .access = "sum"};
    const duet_task_arg_def without_name = {.type = "int"};
    const duet_kernel_text whole = {"k", "return {}", ""},
                           lacking[] = {{NULL, whole.card, whole.text},
                                        {"k", NULL, whole.text},
                                        {"k", whole.card, NULL}};
    duet_task_def good = duet_default_task_def(), def = good;
    REFUSES(duet_task_file_create(NULL, e));
    REFUSES(duet_task_file_create(&(duet_task_def){.kernel = "k"}, e));
    REFUSES(duet_task_file_create(&def, e));
    good.kernel = "k";
    good.items = 4;
    good.args = &y;
    good.n_args = 1;
    good.kernels = &whole;
    good.n_kernels = 1;
    duet_task_file *made = duet_task_file_create(&good, ERR);
    assert_non_null(made);
    duet_task_file_destroy(made);
    REFUSES(duet_task_create(&good, e)); // on no pair
    REFUSES((def = good, def.args = NULL, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.args = &without_name, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.n_args = 0, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.items = 0, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.items = UINT64_MAX, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.work = UINT64_MAX, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.tolerance = NAN, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.n_key = 1, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.key = &nameless, def.n_key = 1, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.key = &without_value, def.n_key = 1, duet_task_file_create(&def, e)));
    REFUSES((def = good, def.kernels = NULL, duet_task_file_create(&def, e)));
    for (int i = 0; i < 3; ++i)
        REFUSES((def = good, def.kernels = &lacking[i], duet_task_file_create(&def, e)));
    REFUSES((def = good, def.path = "twice.task.lua", def.n_settings = 1,
             duet_task_file_create(&def, e)));
}

TEST(create_task)
{
    const duet_setting nameless = {NULL, "1"}, without_value = {"n", NULL};
    duet_task_def def = duet_default_task_def();
    REFUSES(duet_task_create(NULL, e));
    REFUSES(duet_task_create(&def, e));
    def.pair = pair;
    REFUSES(duet_task_create(&def, e));
    def = (duet_task_def){.pair = pair, .path = "twice.task.lua"};
    REFUSES(duet_task_create(&def, e));
    REFUSES(duet_task_file_load(NULL, NULL, 0, e));
    REFUSES(duet_task_file_load("twice.task.lua", NULL, 1, e));
    REFUSES(duet_task_file_load("twice.task.lua", &nameless, 1, e));
    REFUSES(duet_task_file_load("twice.task.lua", &without_value, 1, e));
    describe_task();
    duet_task_file_destroy(NULL);
    duet_task_destroy(NULL);
    assert_null(duet_task_get_arg(NULL, 0));
    assert_int_equal(duet_task_get_items(NULL), 0);
    assert_null(duet_task_get_plan(NULL));
}

TEST(use_task)
{
    const int x[4] = {1, 2, 3, 4};
    duet_task_result ran;
    duet_profile profile;
    duet_task *task = make_task();
    duet_plan plan = *duet_task_get_plan(task);
    REFUSES(duet_task_set_number(NULL, "m", 1, e));
    REFUSES(duet_task_set_number(task, NULL, 1, e));
    REFUSES(duet_task_set_number(task, "m", NAN, e));
    REFUSES(duet_task_set_integer(NULL, "m", 1, e));
    REFUSES(duet_task_set_integer(task, "m", INT64_MAX, e));
    REFUSES(duet_task_set_array(NULL, "x", x, 4, e));
    REFUSES(duet_task_set_array(task, NULL, x, 4, e));
    REFUSES(duet_task_set_array(task, "x", NULL, 4, e));
    REFUSES(duet_task_set_array(task, "x", x, UINT64_MAX, e));
    REFUSES(duet_task_get_array(NULL, "y", NULL, e));
    REFUSES(duet_task_get_array(task, NULL, NULL, e));
    REFUSES(duet_task_set_buffer(NULL, "x", NULL, 0, NULL, e));
    REFUSES(duet_task_set_buffer(task, "x", NULL, 0, NULL, e));
    REFUSES(duet_task_set_plan(NULL, &plan, e));
    REFUSES(duet_task_set_plan(task, NULL, e));
    memset(plan.variant_a, 'x', sizeof plan.variant_a);
    REFUSES(duet_task_set_plan(task, &plan, e));
    REFUSES(duet_task_load_profile(NULL, NULL, &profile, e));
    REFUSES(duet_task_load_profile(task, NULL, NULL, e));
    REFUSES(duet_task_run(NULL, &ran, e));
    REFUSES(duet_task_run(task, NULL, e));
    TAKES(duet_task_run(task, &ran, e));
    duet_task_destroy(task);
}

// ------------------------------------------------------------ tuning and stores

TEST(tune)
{
    static const char *const no_variant[1] = {NULL};
    static const duet_mode no_mode[1] = {(duet_mode)9};
    duet_tune_outcome outcome;
    duet_tune_def def = duet_default_tune_def();
    REFUSES(duet_tune_run(NULL, &outcome, e));
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.keep = false;
    def.pair = pair;
    def.scene = scene;
    REFUSES(duet_tune_run(&def, NULL, e));
    def.n_variants = 1;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.variants = no_variant;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.n_variants = 0;
    def.n_modes = 1;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.modes = no_mode;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.n_modes = 0;
    def.n_levels = 1;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.n_levels = 0;
    def.items = 1;
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.query = "rays both";
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.query = "rays";
    def.n_modes = 1;
    def.modes = &(duet_mode){DUET_MODE_OWN};
    REFUSES(duet_tune_run(&def, &outcome, e));
    def.n_modes = 0;
    def.items = 0;
    def.query = NULL;
    def.strategy = NULL;
    REFUSES(duet_tune_run(&def, &outcome, e));
}

TEST(keep_online)
{
    duet_online_def def = duet_default_online_def();
    REFUSES(duet_online_create(NULL, e));
    REFUSES(duet_online_create(&def, e));
    def.world = world;
    def.most_extra = NAN;
    REFUSES(duet_online_create(&def, e));
    def = duet_default_online_def();
    def.world = world;
    def.modes = &(duet_mode){DUET_MODE_DEFAULT};
    def.n_modes = 1;
    REFUSES(duet_online_create(&def, e));
    def.n_modes = 0;
    def.variants = (const char *const[]){"a", "b", "c", "d", "e"};
    def.n_variants = 5;
    REFUSES(duet_online_create(&def, e));
    def.n_variants = 1;
    REFUSES(duet_online_create(&def, e));
    REFUSES(duet_online_step(NULL, &result, e));
    REFUSES(duet_online_step(online, NULL, e));
    duet_motion_result moved;
    REFUSES(duet_online_advance(NULL, &moved, e));
    REFUSES(duet_online_advance(online, &moved, e));
    duet_task_result ran;
    REFUSES(duet_online_run(NULL, &ran, e));
    REFUSES(duet_online_run(online, &ran, e));
    assert_int_equal(duet_online_get_tunings(NULL), 0);
    assert_true(duet_online_destroy(NULL, NULL));
}

TEST(profiles)
{
    duet_stored_trial *trials = NULL;
    duet_import_counts counts;
    uint32_t n_trials;
    FAILS(DUET_STATUS_NOT_FOUND, duet_profile_list_create("no such store.db", false, e));
    assert_int_equal(duet_profile_list_get_count(NULL), 0);
    assert_null(duet_profile_list_get_profile(NULL, 0));
    duet_profile_list_destroy(NULL);
    REFUSES(duet_profile_get_trials("store.db", NULL, &trials, &n_trials, e));
    REFUSES(duet_profile_get_trials("store.db", "1", NULL, &n_trials, e));
    REFUSES(duet_profile_get_trials("store.db", "1", &trials, NULL, e));
    REFUSES(duet_profile_use("store.db", NULL, e));
    REFUSES(duet_profile_forget("store.db", NULL, e));
    REFUSES(duet_profiles_export("store.db", NULL, e));
    REFUSES(duet_profiles_import("store.db", NULL, &counts, e));
}

TEST(lua_modules)
{
    assert_int_equal(luaopen_duet(NULL), 0);
    assert_int_equal(luaopen_duet_frame(NULL), 0);
    assert_int_equal(luaopen_duet_lab(NULL), 0);
    assert_int_equal(luaopen_duet_plot(NULL), 0);
    assert_int_equal(luaopen_duet_timeline(NULL), 0);
}

// ------------------------------------------------------------ all calls

// They take nothing that could be wrong: they fail without OpenCL, memory, or a store to write to.
static const char unrefused[] =
    " duet_device_list_create  duet_pair_delta_create  duet_online_destroy ";

static const char *const headers[] = {"runtime/duet.h",
                                      "runtime/duet_box_query.h",
                                      "runtime/duet_contact_query.h",
                                      "runtime/duet_pair_delta.h",
                                      "runtime/duet_device.h",
                                      "runtime/duet_level.h",
                                      "runtime/duet_motion.h",
                                      "runtime/duet_motion_commands.h",
                                      "runtime/duet_motion_map.h",
                                      "runtime/duet_object.h",
                                      "runtime/duet_opencl.h",
                                      "runtime/duet_pair_query.h",
                                      "runtime/duet_point_query.h",
                                      "runtime/duet_ray_query.h",
                                      "runtime/duet_replay.h",
                                      "runtime/duet_sweep_query.h",
                                      "runtime/duet_task.h",
                                      "runtime/duet_tree.h",
                                      "runtime/duet_scene.h",
                                      "runtime/duet_world.h",
                                      "base/duet_error.h",
                                      "tuner/duet_tune.h",
                                      "profiles/duet_profiles.h",
                                      "lua/duet_lua.h"};

static uint32_t n_called, n_fallible;

// Reads a file of the source.
static text read_source(const char *path)
{
    own(text) from = {0};
    text_add(&from, "%s/../../%s", getenv("DUET_TEST_DATA"), path);
    return test_read_file(text_chars(&from));
}

static void assert_called_here(const char *name)
{
    char call[80];
    const text here = read_source("tests/api/test_arguments.c");
    snprintf(call, sizeof call, "%s(", name);
    for (const char *at = strstr(here.chars, call); at; at = strstr(at + 1, call))
        if (!isalnum((unsigned char)at[-1]) && at[-1] != '_')
            return;
    fail_msg("%s is not called in this test", name);
}

static void check_call(const char *header, const char *name, bool takes_an_error)
{
    char word[80];
    snprintf(word, sizeof word, " %s ", name);
    assert_called_here(name);
    if (takes_an_error && !strstr(text_chars(&refused), word) && !strstr(unrefused, word))
        fail_msg("%s: %s never failed with an error of its own", header, name);
    ++n_called;
    n_fallible += takes_an_error;
}

// The name before the first bracket behind DUET_API.
static void check_header(const char *header)
{
    const text file = read_source(header);
    for (char *at = strstr(file.chars, "\nDUET_API "); at; at = strstr(at + 1, "\nDUET_API ")) {
        char *bracket = strchr(at, '('), *begin = bracket, *end = strchr(at, ';');
        while (begin > at && (isalnum((unsigned char)begin[-1]) || begin[-1] == '_'))
            --begin;
        *bracket = *end = '\0';
        check_call(header, begin, strstr(bracket + 1, "duet_error *err"));
        *bracket = '(';
        *end = ';';
    }
}

TEST(every_public_call_is_here_with_its_own_failure)
{
    for (size_t i = 0; i < sizeof headers / sizeof headers[0]; ++i)
        check_header(headers[i]);
    assert_true(n_fallible > 90);
}

TEST(every_symbol_of_the_library_is_a_public_call)
{
    char command[4096], name[80];
    uint32_t found = 0;
    snprintf(command, sizeof command, "nm -D --defined-only '%s'", getenv("DUET_LIBRARY"));
    FILE *symbols = popen(command, "r");
    assert_non_null(symbols);
    for (; fscanf(symbols, "%*s T %79s", name) == 1; ++found)
        assert_called_here(name);
    assert_int_equal(pclose(symbols), 0);
    assert_int_equal(found, n_called);
}

// A refused call has changed nothing.
TEST(what_refused_goes_on)
{
    duet_motion_result moved;
    must(duet_world_step(world, &result, ERR));
    assert_int_equal(result.pairs, 1);
    must(duet_motion_advance(motion, &moved, ERR));
}

static duet_world *make_world(duet_world_def def)
{
    def.pair = pair;
    def.plan = duet_default_plan(pair);
    return kept(duet_world_create(&def, ERR));
}

static void make_worlds(void)
{
    duet_world_def def = duet_default_world_def();
    world = make_world(def);
    def.pose_form = DUET_POSE_TRANSFORM;
    apart_world = make_world(def);
    def.pose_form = DUET_POSE_WHOLE;
    def.origin_edge = 1.0f;
    placed_world = make_world(def);
    def.origin_edge = 0.0f;
    def.shape = DUET_SHAPE_BOUNDS;
    bounds_world = make_world(def);
}

// What a default def makes of the thing that it needs.
#define MAKE(kind, needed)                                    \
    __extension__({                                           \
        duet_##kind##_def def_ = duet_default_##kind##_def(); \
        def_.needed = needed;                                 \
        kept(duet_##kind##_create(&def_, ERR));               \
    })

static void close_online(void *of)
{
    duet_online_destroy(of, NULL);
}

static void free_refused(void *names)
{
    text_free(names);
}

static void open_all(void)
{
    const duet_pose two[2] = {pose, pose};
    pair = kept(duet_device_pair_open(NULL, ERR));
    make_worlds();
    scene = kept(duet_scene_create(DUET_OBJECT_POSES, two, 2, 3, 0, ERR));
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, two, 2, ERR));
    must(duet_world_step(world, &result, ERR));
    duet_motion_def moving = duet_scene_motion_def(scene, pair);
    motion = kept(duet_motion_create_from_scene(&moving, scene, NULL, ERR));
    test = MAKE(pair_query, pair);
    duet_tree_def planting = duet_default_tree_def();
    planting.pair = pair;
    planting.share = 0;
    tree = kept(duet_tree_create(&planting, ERR));
    duet_contact_query_def finding = duet_default_contact_query_def();
    finding.pair = pair;
    finding.share = 0;
    touching = kept(duet_contact_query_create(&finding, ERR));
    rays = MAKE(ray_query, tree);
    boxes = MAKE(box_query, tree);
    points = MAKE(point_query, tree);
    sweeps = MAKE(sweep_query, tree);
    duet_online_def keeping = duet_default_online_def();
    keeping.world = world;
    online = test_keep(must(duet_online_create(&keeping, ERR)), close_online);
    test_keep(&refused, free_refused);
}

TEST_BEGIN(open_all)
