// SPDX-License-Identifier: MIT
// Which level is chosen from a table of level costs.
#include "support/test.h"

#include "tuner/level_costs.h"

static const duet_level all[] = {DUET_LEVEL_CERTIFIED, DUET_LEVEL_AABB,  DUET_LEVEL_SPHERE,
                                 DUET_LEVEL_SAT6,      DUET_LEVEL_SAT15, DUET_LEVEL_DOUBLE};

// 10 000 pairs collide.
static const profile_level_cost list[] = {
    {"aabb", 80, 10000, 0, 15000}, {"certified", 110, 10000, 0, 0}, {"double", 200, 10000, 0, 0},
    {"sat15", 100, 10000, 2, 1},   {"sat6", 90, 10000, 0, 900},     {"sphere", 85, 10000, 0, 7000},
};
enum { N = sizeof list / sizeof list[0] };

static duet_level choose(const profile_level_cost *costs, double missed, double false_rate)
{
    duet_level level;
    duet_accuracy accuracy = {missed, false_rate};
    must(level_choose(costs, N, all, DUET_LEVELS, &accuracy, &level, ERR));
    return level;
}

TEST(the_quickest_level_within_the_accuracy_is_chosen)
{
    assert_int_equal(choose(list, 1, 9), DUET_LEVEL_AABB);
    assert_int_equal(choose(list, 0, 1), DUET_LEVEL_SPHERE);
    assert_int_equal(choose(list, 0, 0.09), DUET_LEVEL_SAT6);
    assert_int_equal(choose(list, 0, 0.0899), DUET_LEVEL_CERTIFIED);
    assert_int_equal(choose(list, 0.0002, 0.0001), DUET_LEVEL_SAT15);
    assert_int_equal(choose(list, 0.0001, 0.0001), DUET_LEVEL_CERTIFIED);
}

TEST(a_level_that_promises_more_for_2_percent_comes_first)
{
    profile_level_cost near[N];
    memcpy(near, list, sizeof list);
    near[1].step_ns = 91.8; // certified, against sat6's 90
    assert_int_equal(choose(near, 0, 0.09), DUET_LEVEL_CERTIFIED);
    near[1].step_ns = 91.9;
    assert_int_equal(choose(near, 0, 0.09), DUET_LEVEL_SAT6);
}

TEST(what_no_level_reaches_names_the_nearest)
{
    static const duet_level some[] = {DUET_LEVEL_AABB, DUET_LEVEL_SAT6, DUET_LEVEL_SPHERE};
    const duet_accuracy accuracy = {0, 0.02};
    duet_level level;
    must_fail(level_choose(list, N, some, 3, &accuracy, &level, ERR), DUET_STATUS_NOT_FOUND, "");
    assert_string_equal(ERR->text,
                        "no level to choose from is within missed 0 and false rate 0.02: "
                        "'sat6' comes nearest, with 0 and 0.09");
}

TEST(a_level_without_a_cost_is_not_chosen)
{
    static const duet_level only[] = {DUET_LEVEL_DOUBLE};
    const duet_accuracy accuracy = {0, 0};
    duet_level level;
    must_fail(level_choose(list, 2, only, 1, &accuracy, &level, ERR), DUET_STATUS_NOT_FOUND,
              "runs on both devices");
}

// Which level does where another was asked for: docs/accuracy.md has the table.
TEST(levels_cover_what_they_promise)
{
    static const char covers[DUET_LEVELS][DUET_LEVELS + 1] = {
        [DUET_LEVEL_CERTIFIED] = "111111", [DUET_LEVEL_AABB] = "011100",
        [DUET_LEVEL_SPHERE] = "011100",    [DUET_LEVEL_SAT6] = "011100",
        [DUET_LEVEL_SAT15] = "000010",     [DUET_LEVEL_DOUBLE] = "000011",
    };
    for (int a = 0; a < DUET_LEVELS; ++a)
        for (int b = 0; b < DUET_LEVELS; ++b)
            assert_int_equal(duet_level_covers((duet_level)a, (duet_level)b), covers[a][b] == '1');
}
