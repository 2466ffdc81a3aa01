// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "tuner/online.h"
#include "tuner/race.h"

TEST(medians_and_deviations_of_few_values)
{
    const double odd[] = {9, 1, 5}, even[] = {4, 1, 3, 2};
    assert_true(stats_median(odd, 3) == 5);
    assert_true(stats_median(even, 4) == 2.5);
    assert_true(stats_mad(odd, 3) == 4);
    assert_true(stats_mad(odd, 1) == 0);
}

TEST(a_disturbed_time_is_marked_and_counted)
{
    const double times[] = {10, 11, 10.5, 30, 10.2, 10.8};
    bool marks[6];
    assert_int_equal(stats_mark_outliers(times, 6, marks), 1);
    for (int i = 0; i < 6; ++i)
        assert_int_equal(marks[i], i == 3);
}

// Ranks 1..n: the interval is between the order statistics of the binomial
// table (Conover, table A3).
TEST(the_interval_of_a_median_follows_the_binomial_table)
{
    double ranks[20];
    for (int i = 0; i < 20; ++i)
        ranks[i] = i + 1;
    stats_interval of_20 = stats_median_interval(ranks, 20, 0.95);
    assert_true(of_20.low == 6 && of_20.high == 15);
    assert_true(fabs(of_20.confidence - 0.9586) < 0.0001);
    stats_interval of_8 = stats_median_interval(ranks, 8, 0.99);
    assert_true(of_8.low == 1 && of_8.high == 8);
    assert_true(fabs(of_8.confidence - 0.9922) < 0.0001);
    stats_interval of_3 = stats_median_interval(ranks, 3, 0.95);
    assert_true(of_3.low == 1 && of_3.high == 3 && fabs(of_3.confidence - 0.75) < 0.0001);
}

TEST(an_interval_of_95_percent_holds_the_median_that_often)
{
    rng r = rng_seed(test_seed());
    int held = 0;
    for (int round = 0; round < 2000; ++round) {
        double values[15];
        for (int i = 0; i < 15; ++i)
            values[i] = exp(rng_normal(&r)); // median 1, long tail
        stats_interval in = stats_median_interval(values, 15, 0.95);
        held += in.low <= 1 && 1 <= in.high;
    }
    assert_in_range(held, 1890, 2000);
}

TEST(a_sign_is_decided_once_it_is_sure)
{
    const double differences[] = {0.1, 0.12, 0.09, 0.11};
    assert_int_equal(stats_sign(differences, 1, 0.05, 3), 0);
    assert_int_equal(stats_sign(differences, 4, 0.05, 3), 1);
    const double far = -1;
    assert_int_equal(stats_sign(&far, 1, 0.05, 3), -1);
}

static double noisy(rng *r, double ns, double sigma)
{
    double spike = rng_unit(r) < 0.05 ? rng_between(r, 1.2, 3) : 1;
    return ns * spike * (1 + sigma * rng_normal(r));
}

// Runs the race with such median times, all slowed in the second half.
static void run(race *r, const double *ns, double sigma, rng *random)
{
    uint32_t rival;
    while (race_next(r, &rival))
        race_add(r, rival,
                 noisy(random, ns[rival], sigma) * (r->rivals[rival].rounds < 10 ? 1 : 1.4));
}

static int count_same(double sigma, int races, rng *random)
{
    const double ns[] = {1e7, 1e7};
    int same = 0;
    for (int i = 0; i < races; ++i) {
        race r = race_begin(2, NULL);
        run(&r, ns, sigma, random);
        same += race_compare(&r, 0, 1).verdict == RACE_SAME;
    }
    return same;
}

// One race in a hundred may err, as its interval says; asking after every round
// adds none. 980 of 1000 are four deviations below that.
TEST(equal_plans_are_called_the_same)
{
    static const double sigmas[] = {0.003, 0.03, 0.1};
    rng random = rng_seed(test_seed());
    for (size_t i = 0; i < sizeof sigmas / sizeof *sigmas; ++i) {
        int same = count_same(sigmas[i], 1000, &random);
        print_message("noise %.3f: %d of 1000 the same\n", sigmas[i], same);
        assert_true(same >= 980);
    }
}

TEST(a_quiet_tie_ends_with_the_least_rounds)
{
    race r = race_begin(3, NULL);
    uint32_t rival;
    while (race_next(&r, &rival))
        race_add(&r, rival, 1e7 * (1 + 0.004 * ((rival + r.rivals[rival].rounds) % 3)));
    for (uint32_t i = 0; i < 3; ++i) {
        assert_false(r.rivals[i].out);
        assert_int_equal(r.rivals[i].rounds, r.options.least_rounds);
        assert_int_equal(race_compare(&r, i, 0).verdict, RACE_SAME);
    }
}

// Its interval holds 1 and more than the margin: it may yet win.
TEST(a_rival_that_may_be_much_faster_is_raced_on)
{
    race r = race_begin(2, NULL);
    uint32_t rival;
    while (race_next(&r, &rival))
        race_add(&r, rival, rival == 0 ? 1e7 : r.rivals[1].rounds % 8 == 0 ? 1.01e7 : 0.9e7);
    assert_true(r.rivals[0].rounds > r.options.least_rounds);
}

TEST(a_plan_that_is_a_tenth_faster_wins_even_if_the_machine_slows_down)
{
    rng random = rng_seed(test_seed());
    const double ns[] = {1.1e7, 1e7, 1.3e7};
    int won = 0;
    for (int i = 0; i < 100; ++i) {
        race r = race_begin(3, NULL);
        run(&r, ns, 0.03, &random);
        race_gain gain = race_compare(&r, 1, 0);
        won += race_leader(&r) == 1 && gain.verdict == RACE_FASTER;
        assert_true(gain.interval.low <= gain.ratio && gain.ratio <= gain.interval.high);
        assert_true(race_compare(&r, 2, 1).verdict != RACE_FASTER);
    }
    assert_true(won >= 95);
}

TEST(a_clear_loser_drops_out_early)
{
    rng random = rng_seed(test_seed());
    const double ns[] = {1e7, 5e7};
    race r = race_begin(2, NULL);
    run(&r, ns, 0.03, &random);
    assert_true(r.rivals[1].out);
    assert_int_equal(r.rivals[1].rounds, r.options.least_rounds);
}

// In most rounds 1 is ahead, though its times have the larger median: what is
// slow for a while is slow for all.
TEST(whom_the_others_are_measured_by_stays)
{
    const double ns[] = {1500, 1000, 1300};
    rng random = rng_seed(test_seed());
    const race_options options = {
        .least_rounds = 14, .most_rounds = 40, .confidence = 0.99, .dropped = 1.03, .stay = 1};
    race r = race_begin(3, &options);
    run(&r, ns, 0.02, &random);
    assert_true(r.rivals[2].out && r.rivals[2].rounds < 40);
    assert_true(!r.rivals[0].out && r.rivals[0].rounds == 40);
}

// Whom the others are measured by runs on, with the best of the others, also where it is the best
// itself: of equal plans one is as good as the other.
TEST(one_of_the_others_is_left_once_it_is_to_be_chosen)
{
    rng random = rng_seed(test_seed());
    const race_options options = {.least_rounds = 10,
                                  .most_rounds = 30,
                                  .confidence = 0.99,
                                  .dropped = 1.5,
                                  .stay = 1,
                                  .chosen_after = 12};
    for (int k = 0; k < 50; ++k) {
        const double ns[] = {k % 2 ? 900 : 1100, 1000, 1000, 1040, 1300};
        race r = race_begin(5, &options);
        run(&r, ns, 0.05, &random);
        uint32_t left = 0;
        for (uint32_t i = 1; i < 5; ++i) {
            assert_true(r.rivals[i].out == (r.rivals[i].rounds == 12));
            assert_true(r.rivals[i].out || r.rivals[i].rounds == 30);
            left += !r.rivals[i].out;
        }
        assert_int_equal(left, 1);
        assert_true(r.rivals[4].out);
        assert_true(!r.rivals[0].out && r.rivals[0].rounds == 30);
    }
}

// Also if others are ahead by chance, but not if one is faster for sure.
TEST(the_usual_one_is_chosen_unless_another_is_faster_for_sure)
{
    rng random = rng_seed(test_seed());
    const race_options options = {.least_rounds = 14,
                                  .most_rounds = 30,
                                  .confidence = 0.99,
                                  .dropped = 1.5,
                                  .stay = 1,
                                  .chosen_after = 14,
                                  .usual = 3};
    for (int k = 0; k < 50; ++k) {
        const double near[] = {2000, 1000, 1000, 1000}, far[] = {2000, 1000, 700, 1000};
        race r = race_begin(4, &options), other = r;
        run(&r, near, 0.05, &random);
        run(&other, far, 0.01, &random);
        uint32_t best = race_best(&r, 1, 4);
        assert_true(!r.rivals[3].out || race_compare(&r, best, 3).verdict == RACE_FASTER);
        assert_true(!other.rivals[2].out && other.rivals[3].out && other.rivals[1].out);
    }
}

// A gain of 90 % need not be known as well as one of 2 %.
TEST(a_race_that_is_far_from_a_tie_ends_sooner)
{
    enum { RACES = 50 };
    rng random = rng_seed(test_seed());
    const double slower[] = {1020, 1900};
    uint32_t rounds[2] = {0};
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < RACES; ++i) {
            const double ns[] = {slower[k], 1000};
            const race_options options = {.least_rounds = 14,
                                          .most_rounds = 40,
                                          .confidence = 0.99,
                                          .dropped = INFINITY,
                                          .margin = 0.03};
            race r = race_begin(2, &options);
            run(&r, ns, 0.05, &random);
            rounds[k] += r.rivals[0].rounds;
        }
    assert_true(rounds[0] > 35 * RACES && rounds[1] < 25 * RACES);
}

TEST(the_best_is_who_is_ahead_in_most_rounds)
{
    race r = race_begin(2, NULL);
    static const double ns[3][2] = {{100, 130}, {101, 100}, {112, 110}};
    for (int round = 0; round < 9; ++round) {
        race_add(&r, 0, ns[round % 3][0]);
        race_add(&r, 1, ns[round % 3][1]);
    }
    assert_true(race_median(&r, 0) < race_median(&r, 1));
    assert_int_equal(race_leader(&r), 1);
    assert_int_equal(race_best(&r, 0, 2), 1);
    assert_int_equal(race_best(&r, 0, 1), 0);
    assert_int_equal(race_best(&r, 1, 1), 1);
}

TEST(too_few_rounds_are_called_ambiguous)
{
    race_options few = race_default_options();
    few.least_rounds = few.most_rounds = 3;
    race r = race_begin(2, &few);
    for (int round = 0; round < 3; ++round) {
        race_add(&r, 0, 100 + 10 * round);
        race_add(&r, 1, 120 - 10 * round);
    }
    assert_int_equal(race_compare(&r, 0, 1).verdict, RACE_AMBIGUOUS);
    uint32_t rival;
    assert_false(race_next(&r, &rival));
}

TEST(a_rival_that_cannot_run_leaves_the_others_racing)
{
    race r = race_begin(3, NULL);
    race_drop(&r, 0);
    uint32_t rival, counts[3] = {0};
    while (race_next(&r, &rival)) {
        ++counts[rival];
        race_add(&r, rival, 100.0 + rival);
    }
    assert_int_equal(counts[0], 0);
    assert_true(counts[1] >= r.options.least_rounds && counts[2] >= r.options.least_rounds);
    assert_int_equal(race_leader(&r), 1);
    race_drop(&r, 1);
    race_drop(&r, 2);
    assert_int_equal(race_leader(&r), 3);
}

TEST(times_measured_apart_are_told_by_both_intervals)
{
    const double slow[] = {20, 21, 22, 20.5, 21.5, 22.5, 23};
    const double fast[] = {10, 10.5, 11, 11.5, 12, 10.2, 10.8};
    race_gain gain = race_compare_apart(fast, 7, slow, 7, 0.95);
    assert_int_equal(gain.verdict, RACE_FASTER);
    assert_true(gain.ratio == 21.5 / 10.8);
    assert_true(gain.interval.low == 20 / 12.0 && gain.interval.high == 23 / 10.0);
    assert_true(gain.interval.confidence >= 0.95);
    assert_int_equal(race_compare_apart(slow, 7, fast, 7, 0.95).verdict, RACE_SLOWER);
    assert_int_equal(race_compare_apart(slow, 7, slow, 7, 0.95).verdict, RACE_SAME);
    assert_int_equal(race_compare_apart(fast, 6, slow, 6, 0.95).verdict, RACE_AMBIGUOUS);
}

// ---------------------------------------------------------------- drift

static int steps_until_alarm(rng *r, double factor, double noise, int most)
{
    drift d = {0};
    for (int i = 1; i <= most; ++i)
        if (drift_update(&d, 1e6 * factor * exp(noise * rng_normal(r)), 1e6))
            return i;
    return -1;
}

TEST(a_steady_machine_raises_no_alarm)
{
    rng r = rng_seed(test_seed());
    assert_int_equal(steps_until_alarm(&r, 1, 0.02, 100000), -1);
    assert_int_equal(steps_until_alarm(&r, 1, 0.20, 100000), -1);
    assert_int_equal(steps_until_alarm(&r, 1.02, 0.02, 100000), -1);
}

TEST(a_shift_raises_the_alarm_soon)
{
    rng r = rng_seed(test_seed());
    assert_in_range(steps_until_alarm(&r, 1.3, 0.02, 1000), 2, 20);
    assert_in_range(steps_until_alarm(&r, 0.7, 0.02, 1000), 2, 20);
    assert_in_range(steps_until_alarm(&r, 1.1, 0.05, 1000), 2, 60);
}

TEST(one_hiccup_raises_no_alarm)
{
    drift d = {0};
    for (int i = 0; i < 100; ++i)
        assert_false(drift_update(&d, i == 50 ? 1e9 : 1e6, 1e6));
    assert_false(drift_update(&d, 0.0 / 0.0, 1e6));
}
