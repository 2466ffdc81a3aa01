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

#define CASE(what, collides, dims, ...)     \
    {                                       \
        what, collides, {__VA_ARGS__}, dims \
    }

static const hard_case cases[] = {
    CASE("identical boxes", true, 3, {{1, 2, 3}, CUBE, {0.1f, 0.2f, 0.3f, 0.9f}},
         {{1, 2, 3}, CUBE, {0.1f, 0.2f, 0.3f, 0.9f}}),
    CASE("faces that touch", true, 3, {{0}, CUBE, UPRIGHT}, {{1, 0.25f, 0}, CUBE, UPRIGHT}),
    CASE("edges that touch", true, 3, {{0}, CUBE, UPRIGHT}, {{1, 1, 0}, CUBE, UPRIGHT}),
    CASE("corners that touch", true, 3, {{0}, CUBE, UPRIGHT}, {{1, 1, 1}, CUBE, UPRIGHT}),
    CASE("a separation of one ulp", false, 3, {{0}, CUBE, UPRIGHT},
         {{1 + ULP, 0, 0}, CUBE, UPRIGHT}),
    CASE("an overlap of half an ulp", true, 3, {{0}, CUBE, UPRIGHT},
         {{1 - ULP / 2, 0, 0}, CUBE, UPRIGHT}),
    CASE("turned by 2e-9, a hundredth deep", true, 3, {{0}, CUBE, UPRIGHT},
         {{0.99f, 0, 0}, CUBE, {0, 0, 1e-9f, 1}}),
    CASE("turned by 2e-5, a hundredth deep", true, 3, {{0}, CUBE, UPRIGHT},
         {{0.99f, 0, 0}, CUBE, {0, 1e-5f, 0, 1}}),
    CASE("turned by 2e-3, a hundredth deep", true, 3, {{0}, CUBE, UPRIGHT},
         {{0.99f, 0, 0}, CUBE, {1e-3f, 1e-3f, 0, 1}}),
    CASE("turned by 2e-6, a sixteenth deep, a million away", true, 3,
         {{1e6f, 1e6f, 1e6f}, CUBE, UPRIGHT},
         {{1000000.9375f, 1e6f, 1e6f}, CUBE, {0, 0, 1e-6f, 1}}),
    CASE("a touching face with a turn of 2e-14 about its normal", true, 3, {{0}, CUBE, UPRIGHT},
         {{1, 0, 0}, CUBE, {1e-14f, 0, 0, 1}}),
    CASE("a touching face, the quaternion a thousandth too long", true, 3, {{0}, CUBE, UPRIGHT},
         {{1, 0, 0}, CUBE, {0, 0, 0, 1.001f}}),
    CASE("crossing edges a hair before they part", true, 3, {{0}, CUBE, ABOUT_X},
         {{0, 0, 1.4142135f}, CUBE, ABOUT_Y}),
    CASE("crossing edges a hair after they part", false, 3, {{0}, CUBE, ABOUT_X},
         {{0, 0, 1.4142137f}, CUBE, ABOUT_Y}),
    CASE("crossing edges far into each other", true, 3, {{0}, CUBE, ABOUT_X},
         {{0, 0, 1.3f}, CUBE, ABOUT_Y}),
    CASE("thin beams crossing deep", true, 3, {{0}, {5, 0.05f, 0.05f}, UPRIGHT},
         {{0, 0, 0.05f}, {5, 0.05f, 0.05f}, YAW}),
    CASE("thin beams crossing apart", false, 3, {{0}, {5, 0.05f, 0.05f}, UPRIGHT},
         {{0, 0, 0.11f}, {5, 0.05f, 0.05f}, YAW}),
    CASE("plates 1e-4 apart", false, 3, {{0}, {10, 10, 0.01f}, UPRIGHT},
         {{0, 0, 0.0201f}, {10, 10, 0.01f}, YAW}),
    CASE("plates 1e-4 deep", true, 3, {{0}, {10, 10, 0.01f}, UPRIGHT},
         {{0, 0, 0.0199f}, {10, 10, 0.01f}, YAW}),
    CASE("needles that miss by 1e-5", false, 3, {{0}, {100, 0.01f, 0.01f}, UPRIGHT},
         {{0, 0, 0.02001f}, {100, 0.01f, 0.01f}, YAW}),
    CASE("needles that cross by 1e-5", true, 3, {{0}, {100, 0.01f, 0.01f}, UPRIGHT},
         {{0, 0, 0.01999f}, {100, 0.01f, 0.01f}, YAW}),
    CASE("rectangles of one plane that touch", true, 3, {{0}, {1, 2, 0}, UPRIGHT},
         {{2, 0, 0}, {1, 2, 0}, UPRIGHT}),
    CASE("rectangles of planes 1e-45 apart", false, 3, {{0}, {1, 2, 0}, UPRIGHT},
         {{2, 0, 0x1p-149f}, {1, 2, 0}, UPRIGHT}),
    CASE("rectangles of one plane, turned", true, 3, {{0}, {1, 2, 0}, YAW},
         {{1, 1, 0}, {1, 2, 0}, {0, 0, -0.5f, 1}}),
    // The edges of q = (1, 2, 2, 4) point along whole 25ths.
    CASE("a point inside", true, 3, {{0}, {25, 50, 75}, {1, 2, 2, 4}},
         {{8, 19, -11}, {0, 0, 0}, {3, 1, 2, 7}}),
    CASE("a point on a turned face", true, 3, {{0}, {25, 50, 75}, {1, 2, 2, 4}},
         {{9, 20, -12}, {0, 0, 0}, {3, 1, 2, 7}}),
    CASE("a point an ulp off a turned face", false, 3, {{0}, {25, 50, 75}, {1, 2, 2, 4}},
         {{9 + 8 * ULP, 20, -12}, {0, 0, 0}, {3, 1, 2, 7}}),
    CASE("a small box deep in a huge one", true, 3, {{0}, {1e4f, 1e4f, 1e4f}, {1, 2, 3, 4}},
         {{50, 3, 900}, {1, 1, 1}, {4, 3, 2, 1}}),
    CASE("a box that touches one a million times its size", true, 3,
         {{0}, {1e6f, 1e6f, 1e6f}, UPRIGHT}, {{1000001, 7, 0}, {1, 1, 1}, UPRIGHT}),
    CASE("a box an ulp from one a million times its size", false, 3,
         {{0}, {1e6f, 1e6f, 1e6f}, UPRIGHT}, {{1000001.0625f, 7, 0}, {1, 1, 1}, UPRIGHT}),
    CASE("a quarter turn from sine and cosine, touching", true, 3, {{0}, CUBE, UPRIGHT},
         {{1, 0, 0}, CUBE, {0.70710677f, 0, 0, 0.70710677f}}),
    CASE("a quarter turn an ulp wrong, touching", true, 3, {{0}, CUBE, UPRIGHT},
         {{1, 0, 0}, CUBE, {0.70710677f, 0, 0, 0.70710683f}}),
    CASE("denormal boxes that touch", true, 3, {{0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT},
         {{0x1p-139f, 0, 0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT}),
    CASE("denormal boxes one denormal apart", false, 3,
         {{0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT},
         {{0x1p-139f + 0x1p-149f, 0, 0}, {0x1p-140f, 0x1p-140f, 0x1p-140f}, UPRIGHT}),
    CASE("boxes of half the floats' range that touch", true, 3,
         {{-0x1p127f, 0, 0}, {0x1p127f, 1, 1}, UPRIGHT},
         {{0x1p127f, 0, 0}, {0x1p127f, 1, 1}, UPRIGHT}),
    CASE("small boxes at both ends of the floats' range", false, 3, {{-3e38f, 0, 0}, CUBE, YAW},
         {{3e38f, 0, 0}, CUBE, YAW}),
    CASE("zeros of both signs", true, 3, {{0.0f, -0.0f, 0.0f}, CUBE, {-0.0f, 0, 0, -1}},
         {{1, 0.0f, -0.0f}, CUBE, {0, -0.0f, 0, 1}}),
    // Cosine 4/5, sine 3/5.
    CASE("squares of a plane, turned, a corner on a side", true, 2, {{0}, {5, 5, 0}, UPRIGHT},
         {{12, 0, 0}, {5, 5, 0}, {0, 0, 1, 3}}),
    CASE("squares of a plane, turned, a corner an ulp off a side", false, 2,
         {{0}, {5, 5, 0}, UPRIGHT}, {{12 + 8 * ULP, 0, 0}, {5, 5, 0}, {0, 0, 1, 3}}),
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

static void check_case(const hard_case *c)
{
    hard_pair pair = c->pair;
    hard_pair swapped = {pair.b, pair.a};
    hard_pair negated = {with_minus_q(pair.a), with_minus_q(pair.b)};
    check_pair(&pair, c->dims, c->collide);
    check_pair(&swapped, c->dims, c->collide);
    check_pair(&negated, c->dims, c->collide);
}

TEST(hard_cases_are_answered_right)
{
    for (int i = 0; i < N_CASES; ++i) {
        print_message("%s\n", cases[i].name);
        check_case(&cases[i]);
    }
}
