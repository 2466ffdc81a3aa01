// SPDX-License-Identifier: MIT
// The narrow phase alone: pairs that the caller brings, through the public API.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_test.h"

static duet_pair_query *open_test(duet_level level, uint32_t share)
{
    duet_pair_query_def def = duet_default_pair_query_def();
    def.pair = default_pair();
    def.level = level;
    def.share = share;
    return kept(duet_pair_query_create(&def, ERR));
}

// Cubes in a row, every third pair apart.
static void fill_row(duet_pose *poses, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i) {
        poses[2 * i] = cube_at((float)i, 0, 0, 0.5);
        poses[2 * i + 1] = cube_at((float)i, i % 3 == 2 ? 1.5f : 0.75f, 0, 0.5);
    }
}

// ------------------------------------------------------------ hard pairs

enum { EACH = 250 };

TEST(hard_pairs_in_3d_get_what_their_level_promises)
{
    hard_test_run(3, EACH);
}

TEST(hard_pairs_in_2d_get_what_their_level_promises)
{
    hard_test_run(2, EACH);
}

// ------------------------------------------------------------ a world's candidates

enum { OBJECTS = 3000 };

static uint64_t random_scene(duet_pose *poses)
{
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < OBJECTS; ++i)
        for (int k = 0; k < 4; ++k) {
            poses[i].rotation[k] = (float)rng_normal(&r);
            if (k < 3) {
                poses[i].centre[k] = (float)rng_between(&r, 0, 20);
                poses[i].half_extents[k] = (float)rng_between(&r, 0.1, 0.6);
            }
        }
    return OBJECTS;
}

static void step_at(duet_world *world, duet_level level, duet_result *result)
{
    must(duet_world_set_level(world, level, ERR));
    must(duet_world_step(world, result, ERR));
}

// The pairs of level aabb are the candidates; tested, they are the step's pairs.
TEST(a_step_s_candidates_tested_alone_are_its_pairs)
{
    static duet_pose objects[OBJECTS];
    duet_result result;
    duet_world_def def = devices_def(3);
    duet_world *world = create_world(&def);
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, objects, (uint32_t)random_scene(objects),
                                ERR));
    step_at(world, DUET_LEVEL_AABB, &result);
    uint64_t n = result.pairs;
    duet_pair *pairs = test_alloc(n * sizeof *pairs);
    duet_pose *poses = test_alloc(2 * n * sizeof *poses);
    uint8_t *answers = test_alloc(n);
    for (uint64_t i = 0; i < n; ++i) {
        pairs[i] = duet_result_get_pair(&result, i);
        poses[2 * i] = objects[pairs[i].a];
        poses[2 * i + 1] = objects[pairs[i].b];
    }
    for (int level = 0; level < DUET_LEVELS; ++level) {
        duet_pair_query_result tested;
        uint64_t hash = 0;
        hard_test_answers((duet_level)level, 3, DUET_SHARE_ONE / 2, poses, n, answers, &tested);
        for (uint64_t i = 0; i < n; ++i)
            hash += answers[i] ? duet_pairs_hash(&pairs[i], 1) : 0;
        step_at(world, (duet_level)level, &result);
        assert_int_equal(tested.colliding, result.pairs);
        assert_int_equal(hash, duet_result_get_hash(&result));
        assert_true(level != DUET_LEVEL_CERTIFIED || tested.undecided == result.undecided);
    }
}

// ------------------------------------------------------------ numbers of pairs

// More than two chunks of 2^18 for one device, and all small remainders.
TEST(any_number_of_pairs_is_tested_and_nothing_else_written)
{
    static const uint64_t counts[] = {0, 1, 2, 7, 8, 9, 513, 262143, 262145, 524289 + 5};
    enum { MOST = 524289 + 5, GUARD = 64 };
    duet_pose *poses = test_alloc(2 * MOST * sizeof *poses);
    uint8_t *answers = test_alloc(MOST + GUARD);
    assert_true(poses && answers);
    fill_row(poses, MOST);
    for (uint32_t share = 0; share <= DUET_SHARE_ONE; share += DUET_SHARE_ONE / 2) {
        duet_pair_query *test = open_test(DUET_LEVEL_SPHERE, share);
        for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
            duet_pair_query_result result;
            uint64_t n = counts[c];
            memset(answers, 77, MOST + GUARD);
            must(duet_pair_query_run(test, poses, n, answers, NULL, &result, ERR));
            uint64_t colliding = 0;
            for (uint64_t i = 0; i < MOST + GUARD; ++i) {
                assert_int_equal(answers[i], i < n ? i % 3 != 2 : 77);
                colliding += answers[i] == 1;
            }
            assert_int_equal(result.colliding, colliding);
        }
    }
}

TEST(gaps_are_those_of_the_best_axis_at_any_share)
{
    enum { N = 100 };
    duet_pose poses[2 * N];
    uint8_t answers[N];
    double separations[N];
    fill_row(poses, N);
    for (uint32_t share = 0; share <= DUET_SHARE_ONE; share += DUET_SHARE_ONE / 4) {
        duet_pair_query_result result;
        duet_pair_query *test = open_test(DUET_LEVEL_CERTIFIED, share);
        must(duet_pair_query_run(test, poses, N, answers, separations, &result, ERR));
        for (int i = 0; i < N; ++i) {
            assert_int_equal(answers[i], i % 3 != 2);
            assert_true(separations[i] == (i % 3 == 2 ? 0.5 : -0.25));
        }
    }
}

TEST(touching_pairs_are_decided_on_the_host_and_counted)
{
    duet_pair_query_result result;
    uint8_t answers[2];
    const duet_pose poses[] = {cube_at(0, 0, 0, 0.5), cube_at(1, 0, 0, 0.5), cube_at(0, 0, 0, 0.5),
                               cube_at(nextafterf(1, 2), 0, 0, 0.5)};
    duet_pair_query *test = open_test(DUET_LEVEL_CERTIFIED, 0);
    must(duet_pair_query_run(test, poses, 2, answers, NULL, &result, ERR));
    assert_int_equal(answers[0], 1);
    assert_int_equal(answers[1], 0);
    assert_int_equal(result.undecided, 2);
}

// ------------------------------------------------------------ refusals

static void expect_refused(const duet_pose *poses, uint64_t n, uint32_t share, const char *why)
{
    duet_pair_query_result result;
    uint8_t *answers = test_alloc(n);
    duet_pair_query *test = open_test(DUET_LEVEL_SAT15, share);
    must_fail(duet_pair_query_run(test, poses, n, answers, NULL, &result, ERR),
              DUET_STATUS_BAD_OBJECT, "");
    assert_string_equal(ERR->text, why);
}

TEST(each_kind_of_bad_pose_is_named_with_its_pair)
{
    enum { N = 20 };
    static const char because[] = "pose is not a number, infinite, negative or without rotation";
    for (int kind = 0; kind < 6; ++kind) {
        duet_pose poses[2 * N];
        char why[120];
        fill_row(poses, N);
        duet_pose *bad = &poses[2 * 13 + kind % 2];
        float *const places[] = {&bad->centre[0],       &bad->centre[1],   &bad->half_extents[2],
                                 &bad->half_extents[1], &bad->rotation[0], &bad->rotation[3]};
        static const float values[] = {NAN, INFINITY, -INFINITY, -1e-30f, NAN, 0};
        *places[kind] = values[kind];
        snprintf(why, sizeof why, "pair 13: the %s %s", kind % 2 ? "second" : "first", because);
        expect_refused(poses, N, 0, why);
    }
}

TEST(of_several_bad_pairs_the_first_is_named)
{
    enum { N = 600000 };
    duet_pose *poses = test_alloc(2 * N * sizeof *poses);
    fill_row(poses, N);
    poses[2 * 599999].half_extents[0] = -1;
    poses[2 * 299990 + 1].half_extents[0] = -1;
    poses[2 * 299991].half_extents[0] = -1;
    for (uint32_t share = 0; share <= DUET_SHARE_ONE; share += DUET_SHARE_ONE / 2)
        expect_refused(poses, N, share,
                       "pair 299990: the second pose is not a number, infinite, negative or "
                       "without rotation");
}

TEST(a_test_goes_on_after_a_refusal)
{
    duet_pair_query_result result;
    uint8_t answer;
    duet_pose poses[2] = {cube_at(0, 0, 0, 0.5), cube_at(0, 0, 0, 0.5)};
    duet_pair_query *test = open_test(DUET_LEVEL_DOUBLE, 0);
    poses[0].half_extents[0] = NAN;
    assert_false(duet_pair_query_run(test, poses, 1, &answer, NULL, &result, NULL));
    poses[0].half_extents[0] = 1;
    must(duet_pair_query_run(test, poses, 1, &answer, NULL, &result, ERR));
    assert_int_equal(answer, 1);
    must_fail(duet_pair_query_run(test, NULL, 1, &answer, NULL, &result, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "1 pairs, but no memory for their poses");
}

TEST(a_wrong_def_is_told)
{
    duet_pair_query_def right = duet_default_pair_query_def();
    right.pair = default_pair();
    duet_pair_query_def wrong[5] = {right, right, right, right, right};
    static const char *const why[] = {
        "the query's def does not come from duet_default_pair_query_def",
        "the query's def has no device pair",
        "dims is 4; expected 2 or 3",
        "level is 6; expected a duet_level",
        "share is 65537 of 65536; expected at most all of it",
    };
    wrong[0].cookie = 0;
    wrong[1].pair = NULL;
    wrong[2].dims = 4;
    wrong[3].level = (duet_level)DUET_LEVELS;
    wrong[4].share = DUET_SHARE_ONE + 1;
    for (int i = 0; i < 5; ++i) {
        must_fail(duet_pair_query_create(&wrong[i], ERR), DUET_STATUS_BAD_ARGUMENT, "");
        assert_string_equal(ERR->text, why[i]);
    }
}
