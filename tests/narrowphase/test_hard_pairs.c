// SPDX-License-Identifier: MIT
// Single pairs on which collision tests go wrong, each a test of its own: the
// exact answer is known, and every level keeps its promise, whichever box comes
// first and whatever sign the quaternions have.
#include "support/test.h"

#include "support/hard_pairs.h"
#include "support/oracle.h"
#include "support/promise.h"

#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/narrow.h"

typedef struct hard_case {
    const char *name;
    bool collide;
    hard_pair pair;
    uint32_t dims;
} hard_case;

#define UPRIGHT    \
    {              \
        0, 0, 0, 1 \
    }
#define YAW              \
    {                    \
        0, 0, 0.3f, 0.9f \
    }
#define ABOUT_X                            \
    {                                      \
        0.3826834324f, 0, 0, 0.9238795325f \
    } // 45 degrees
#define ABOUT_Y                            \
    {                                      \
        0, 0.3826834324f, 0, 0.9238795325f \
    }
#define CUBE             \
    {                    \
        0.5f, 0.5f, 0.5f \
    }
#define ULP 0x1p-23f // the last bit of 1

static const hard_case cases[] = {
    {"identical boxes",
     true,
     {{{1, 2, 3}, CUBE, {0.1f, 0.2f, 0.3f, 0.9f}}, {{1, 2, 3}, CUBE, {0.1f, 0.2f, 0.3f, 0.9f}}},
     3},
    {"faces that touch", true, {{{0}, CUBE, UPRIGHT}, {{1, 0.25f, 0}, CUBE, UPRIGHT}}, 3},
    {"edges that touch", true, {{{0}, CUBE, UPRIGHT}, {{1, 1, 0}, CUBE, UPRIGHT}}, 3},
    {"corners that touch", true, {{{0}, CUBE, UPRIGHT}, {{1, 1, 1}, CUBE, UPRIGHT}}, 3},
    {"a separation of one ulp", false, {{{0}, CUBE, UPRIGHT}, {{1 + ULP, 0, 0}, CUBE, UPRIGHT}}, 3},
    {"an overlap of half an ulp",
     true,
     {{{0}, CUBE, UPRIGHT}, {{1 - ULP / 2, 0, 0}, CUBE, UPRIGHT}},
     3},
    {"turned by 2e-9, a hundredth deep",
     true,
     {{{0}, CUBE, UPRIGHT}, {{0.99f, 0, 0}, CUBE, {0, 0, 1e-9f, 1}}},
     3},
    {"turned by 2e-5, a hundredth deep",
     true,
     {{{0}, CUBE, UPRIGHT}, {{0.99f, 0, 0}, CUBE, {0, 1e-5f, 0, 1}}},
     3},
    {"turned by 2e-3, a hundredth deep",
     true,
     {{{0}, CUBE, UPRIGHT}, {{0.99f, 0, 0}, CUBE, {1e-3f, 1e-3f, 0, 1}}},
     3},
    {"turned by 2e-6, a sixteenth deep, a million away",
     true,
     {{{1e6f, 1e6f, 1e6f}, CUBE, UPRIGHT}, {{1000000.9375f, 1e6f, 1e6f}, CUBE, {0, 0, 1e-6f, 1}}},
     3},
    {"a touching face with a turn of 2e-14 about its normal",
     true,
     {{{0}, CUBE, UPRIGHT}, {{1, 0, 0}, CUBE, {1e-14f, 0, 0, 1}}},
     3},
    {"a touching face, the quaternion a thousandth too long",
     true,
     {{{0}, CUBE, UPRIGHT}, {{1, 0, 0}, CUBE, {0, 0, 0, 1.001f}}},
     3},
    {"crossing edges a hair before they part",
     true,
     {{{0}, CUBE, ABOUT_X}, {{0, 0, 1.4142135f}, CUBE, ABOUT_Y}},
     3},
    {"crossing edges a hair after they part",
     false,
     {{{0}, CUBE, ABOUT_X}, {{0, 0, 1.4142137f}, CUBE, ABOUT_Y}},
     3},
    {"crossing edges far into each other",
     true,
     {{{0}, CUBE, ABOUT_X}, {{0, 0, 1.3f}, CUBE, ABOUT_Y}},
     3},
    {"thin beams crossing deep",
     true,
     {{{0}, {5, 0.05f, 0.05f}, UPRIGHT}, {{0, 0, 0.05f}, {5, 0.05f, 0.05f}, YAW}},
     3},
    {"thin beams crossing apart",
     false,
     {{{0}, {5, 0.05f, 0.05f}, UPRIGHT}, {{0, 0, 0.11f}, {5, 0.05f, 0.05f}, YAW}},
     3},
    {"plates 1e-4 apart",
     false,
     {{{0}, {10, 10, 0.01f}, UPRIGHT}, {{0, 0, 0.0201f}, {10, 10, 0.01f}, YAW}},
     3},
    {"plates 1e-4 deep",
     true,
     {{{0}, {10, 10, 0.01f}, UPRIGHT}, {{0, 0, 0.0199f}, {10, 10, 0.01f}, YAW}},
     3},
    {"needles that miss by 1e-5",
     false,
     {{{0}, {100, 0.01f, 0.01f}, UPRIGHT}, {{0, 0, 0.02001f}, {100, 0.01f, 0.01f}, YAW}},
     3},
    {"needles that cross by 1e-5",
     true,
     {{{0}, {100, 0.01f, 0.01f}, UPRIGHT}, {{0, 0, 0.01999f}, {100, 0.01f, 0.01f}, YAW}},
     3},
    {"rectangles of one plane that touch",
     true,
     {{{0}, {1, 2, 0}, UPRIGHT}, {{2, 0, 0}, {1, 2, 0}, UPRIGHT}},
     3},
    {"rectangles of planes 1e-45 apart",
     false,
     {{{0}, {1, 2, 0}, UPRIGHT}, {{2, 0, 0x1p-149f}, {1, 2, 0}, UPRIGHT}},
     3},
    {"rectangles of one plane, turned",
     true,
     {{{0}, {1, 2, 0}, YAW}, {{1, 1, 0}, {1, 2, 0}, {0, 0, -0.5f, 1}}},
     3},
    // The edges of q = (1, 2, 2, 4) point along whole 25ths.
    {"a point inside",
     true,
     {{{0}, {25, 50, 75}, {1, 2, 2, 4}}, {{8, 19, -11}, {0, 0, 0}, {3, 1, 2, 7}}},
     3},
    {"a point on a turned face",
     true,
     {{{0}, {25, 50, 75}, {1, 2, 2, 4}}, {{9, 20, -12}, {0, 0, 0}, {3, 1, 2, 7}}},
     3},
    {"a point an ulp off a turned face",
     false,
     {{{0}, {25, 50, 75}, {1, 2, 2, 4}}, {{9 + 8 * ULP, 20, -12}, {0, 0, 0}, {3, 1, 2, 7}}},
     3},
    {"a small box deep in a huge one",
     true,
     {{{0}, {1e4f, 1e4f, 1e4f}, {1, 2, 3, 4}}, {{50, 3, 900}, {1, 1, 1}, {4, 3, 2, 1}}},
     3},
    {"a box that touches one a million times its size",
     true,
     {{{0}, {1e6f, 1e6f, 1e6f}, UPRIGHT}, {{1000001, 7, 0}, {1, 1, 1}, UPRIGHT}},
     3},
    {"a box an ulp from one a million times its size",
     false,
     {{{0}, {1e6f, 1e6f, 1e6f}, UPRIGHT}, {{1000001.0625f, 7, 0}, {1, 1, 1}, UPRIGHT}},
     3},
    {"a quarter turn from sine and cosine, touching",
     true,
     {{{0}, CUBE, UPRIGHT}, {{1, 0, 0}, CUBE, {0.70710677f, 0, 0, 0.70710677f}}},
     3},
    {"a quarter turn an ulp wrong, touching",
     true,
     {{{0}, CUBE, UPRIGHT}, {{1, 0, 0}, CUBE, {0.70710677f, 0, 0, 0.70710683f}}},
     3},
    {"denormal boxes that touch",
     true,
     {{{0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT},
      {{0x1p-139f, 0, 0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT}},
     3},
    {"denormal boxes one denormal apart",
     false,
     {{{0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT},
      {{0x1p-139f + 0x1p-149f, 0, 0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT}},
     3},
    {"boxes of half the floats' range that touch",
     true,
     {{{-0x1p127f, 0, 0}, {0x1p127f, 1, 1}, UPRIGHT},
      {{0x1p127f, 0, 0}, {0x1p127f, 1, 1}, UPRIGHT}},
     3},
    {"small boxes at both ends of the floats' range",
     false,
     {{{-3e38f, 0, 0}, CUBE, YAW}, {{3e38f, 0, 0}, CUBE, YAW}},
     3},
    {"zeros of both signs",
     true,
     {{{0.0f, -0.0f, 0.0f}, CUBE, {-0.0f, 0, 0, -1}}, {{1, 0.0f, -0.0f}, CUBE, {0, -0.0f, 0, 1}}},
     3},
    {"squares of a plane, turned, a corner on a side",
     true,
     {{{0}, {5, 5, 0}, UPRIGHT}, {{12, 0, 0}, {5, 5, 0}, {0, 0, 1, 3}}}, // cosine 4/5, sine 3/5
     2},
    {"squares of a plane, turned, a corner an ulp off a side",
     false,
     {{{0}, {5, 5, 0}, UPRIGHT}, {{12 + 8 * ULP, 0, 0}, {5, 5, 0}, {0, 0, 1, 3}}},
     2},
};

enum { N_CASES = sizeof cases / sizeof *cases };

static void keep_promises(const hard_pair *pair, uint32_t dims)
{
    for (int l = 0; l < DUET_LEVELS; ++l) {
        const duet_level_info *info = duet_level_get_info((duet_level)l);
        bool answer = level_collide((duet_level)l, &pair->a, &pair->b, narrow_here, dims, true);
        if (!promise_allows(info->missed, info->added, pair, dims, answer)) {
            hard_pair_print(pair, dims);
            fail_msg("level %s breaks its promise", info->name);
        }
    }
}

static duet_pose with_minus_q(duet_pose pose)
{
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = -pose.rotation[i];
    return pose;
}

static void check_pair(const hard_pair *pair, uint32_t dims, bool collide)
{
    assert_int_equal(oracle_collide(&pair->a, &pair->b, dims), collide);
    assert_int_equal(narrow_exact(&pair->a, &pair->b, dims), collide);
    assert_int_equal(duet_poses_collide(&pair->a, &pair->b, dims), collide);
    keep_promises(pair, dims);
}

static void check_case(void **state)
{
    const hard_case *c = *state;
    hard_pair pair = c->pair;
    hard_pair swapped = {pair.b, pair.a};
    hard_pair negated = {with_minus_q(pair.a), with_minus_q(pair.b)};
    check_pair(&pair, c->dims, c->collide);
    check_pair(&swapped, c->dims, c->collide);
    check_pair(&negated, c->dims, c->collide);
}

int main(void)
{
    struct CMUnitTest tests[N_CASES];
    for (int i = 0; i < N_CASES; ++i)
        tests[i] = (struct CMUnitTest){
            .name = cases[i].name,
            .test_func = check_case,
            .initial_state = (void *)&cases[i],
        };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
