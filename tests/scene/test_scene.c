// SPDX-License-Identifier: MIT
#include "support/test.h"

#include <float.h>

#define UNIT_CUBE                                                      \
    {                                                                  \
        .half_extents = {0.5f, 0.5f, 0.5f}, .rotation = { 0, 0, 0, 1 } \
    }

static void assert_pose_refused(const duet_pose *pose, uint32_t dims, const char *says)
{
    duet_pose poses[3] = {UNIT_CUBE, UNIT_CUBE, *pose};
    must_fail(duet_scene_create(DUET_OBJECT_POSES, poses, 3, dims, 0, ERR), DUET_STATUS_BAD_OBJECT,
              says);
}

TEST(a_bad_pose_is_refused_by_its_id)
{
    duet_pose pose = UNIT_CUBE;
    pose.centre[1] = NAN;
    assert_pose_refused(&pose, 3, "object 2: cy is nan; every number must be finite");
    pose.centre[1] = INFINITY;
    assert_pose_refused(&pose, 3, "object 2: cy is inf");
    pose = (duet_pose)UNIT_CUBE;
    pose.half_extents[2] = -FLT_TRUE_MIN;
    assert_pose_refused(&pose, 3, "hz = -1.4013e-45 is negative; a half extent is 0 or more");
    pose = (duet_pose)UNIT_CUBE;
    pose.rotation[3] = 0;
    assert_pose_refused(&pose, 3, "object 2: the quaternion is zero");
    assert_pose_refused(&pose, 2, "object 2: the quaternion is zero");
    pose.rotation[0] = NAN;
    assert_pose_refused(&pose, 3, "object 2: qx is nan");
}

TEST(bad_bounds_are_refused_by_their_id)
{
    duet_bounds bounds[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 2, 0}, {1, 1, 1}}};
    must_fail(duet_scene_create(DUET_OBJECT_BOUNDS, bounds, 2, 3, 0, ERR), DUET_STATUS_BAD_OBJECT,
              "");
    assert_string_equal(ERR->text, "object 1: min y = 2 is above max y = 1");
    bounds[1].lower[1] = -INFINITY;
    must_fail(duet_scene_create(DUET_OBJECT_BOUNDS, bounds, 2, 2, 0, ERR), DUET_STATUS_BAD_OBJECT,
              "object 1: min y is -inf");
}

TEST(dims_other_than_2_and_3_are_refused)
{
    must_fail(duet_scene_create(DUET_OBJECT_POSES, NULL, 0, 4, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_string_equal(ERR->text, "dims is 4; it must be 2 or 3");
    assert_null(duet_scene_create(DUET_OBJECT_BOUNDS, NULL, 0, 0, 0, NULL));
}

TEST(missing_memory_and_paths_are_refused)
{
    must_fail(duet_scene_create(DUET_OBJECT_POSES, NULL, 1, 3, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_null(duet_scene_create(DUET_OBJECT_BOUNDS, NULL, 1, 3, 0, NULL));
    assert_null(duet_scene_load(NULL, NULL, 0, NULL));
    duet_scene_destroy(NULL);
}

TEST(none_and_one_and_two_objects_make_a_scene)
{
    const duet_pose poses[2] = {UNIT_CUBE, UNIT_CUBE};
    for (uint32_t n = 0; n <= 2; ++n) {
        duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, poses, n, 3, 0, ERR));
        assert_int_equal(duet_scene_get_info(scene)->n, n);
        assert_non_null(duet_scene_get_objects(scene, DUET_OBJECT_POSES));
        assert_null(duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS));
    }
}

TEST(what_2d_does_not_read_is_zero_in_the_scene)
{
    const duet_pose pose = {{1, 2, NAN}, {3, 4, -1}, {NAN, INFINITY, 0, 2}};
    duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 2, 0, ERR));
    const duet_pose want = {{1, 2, 0}, {3, 4, 0}, {0, 0, 0, 2}};
    assert_memory_equal(duet_scene_get_objects(scene, DUET_OBJECT_POSES), &want, sizeof want);
    assert_false(duet_scene_get_info(scene)->rotated);
    const duet_bounds box = {{1, 2, NAN}, {3, 4, -1}};
    scene = kept(duet_scene_create(DUET_OBJECT_BOUNDS, &box, 1, 2, 0, ERR));
    const duet_bounds want_box = {{1, 2, 0}, {3, 4, 0}};
    assert_memory_equal(duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS), &want_box,
                        sizeof want_box);
}

static duet_scene *scene_of_rotation(float x, float y, float z, float w)
{
    duet_pose pose = UNIT_CUBE;
    memcpy(pose.rotation, (const float[4]){x, y, z, w}, sizeof pose.rotation);
    return kept(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 3, 0, ERR));
}

TEST(a_scene_is_rotated_where_a_vector_part_is_not_zero)
{
    static const struct {
        float q[4];
        bool rotated;
    } cases[] = {
        {{0, 0, 0, 1}, false}, {{0, 0, -0.0f, -7}, false}, {{0, 0, 0, 1e-40f}, false},
        {{1, 0, 0, 0}, true},  {{0, 1e-45f, 0, 1}, true},  {{0, 0, 1e-30f, 1}, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const float *q = cases[i].q;
        duet_scene *scene = scene_of_rotation(q[0], q[1], q[2], q[3]);
        assert_int_equal(duet_scene_get_info(scene)->rotated, cases[i].rotated);
    }
}

// The scale is a power of two, so the parts keep their ratios bit for bit.
TEST(a_quaternion_of_any_length_keeps_its_rotation)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 10000; ++round) {
        int shift = (int)rng_below(&r, 220) - 110;
        float q[4];
        for (int k = 0; k < 4; ++k)
            q[k] = ldexpf((float)rng_between(&r, -1, 1), shift);
        duet_scene *scene = scene_of_rotation(q[0], q[1], q[2], q[3]);
        const float *kept = test_poses(scene)->rotation;
        float squared = 0;
        for (int k = 0; k < 4; ++k) {
            squared += kept[k] * kept[k];
            assert_true((double)kept[k] * (double)q[0] == (double)q[k] * (double)kept[0]);
        }
        assert_true(isnormal(squared));
    }
}

TEST(the_pair_hash_does_not_depend_on_order_or_spans)
{
    const duet_pair pairs[] = {{0, 1}, {1, 2}, {5, 4294967294u}};
    const duet_pair turned[] = {{5, 4294967294u}, {0, 1}, {1, 2}};
    uint64_t hash = duet_pairs_hash(pairs, 3);
    assert_true(hash == duet_pairs_hash(turned, 3));
    assert_true(hash != duet_pairs_hash(pairs, 2));
    assert_true(duet_pairs_hash(pairs, 0) == 0);
    duet_result result = {.spans = {{turned, 1}, {turned + 1, 2}}, .pairs = 3};
    assert_true(duet_result_get_hash(&result) == hash);
    for (uint64_t i = 0; i < 3; ++i) {
        duet_pair pair = duet_result_get_pair(&result, i);
        assert_memory_equal(&pair, &turned[i], sizeof pair);
    }
}

// Worked out by hand from the definition in duet.h: k = 1 for the pair (0, 1).
TEST(the_pair_hash_is_the_documented_one)
{
    const duet_pair pair = {0, 1};
    uint64_t k = 0x9E3779B97F4A7C15u;
    k ^= k >> 29;
    k *= 0xBF58476D1CE4E5B9u;
    k ^= k >> 32;
    assert_true(duet_pairs_hash(&pair, 1) == k);
}

TEST_MAIN(NULL, NULL)
