// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "tuner/online.h"
#include "tuner/replay.h"

#include <math.h>

// Frames by a model; gives the longest, in units of what the share that was
// kept before would take.
static double run_frames(online *o, const replay_model *model, rng *r, uint32_t n)
{
    double longest = 0;
    for (uint32_t i = 0; i < n; ++i) {
        duet_error err = {0};
        uint32_t share, kept = o->share;
        assert_ok(online_share(o, &share, &err), err);
        search_sample frame = replay_launch(model, share, r);
        assert_ok(online_tell(o, &frame, &err), err);
        double plain = (double)replay_launch(model, kept, NULL).total_ns;
        longest = fmax(longest, (double)frame.total_ns / plain);
    }
    return longest;
}

static void a_device_that_slows_down_gets_less_work(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    replay_model even = {.ratio = 1, .sigma = 0.03}, slowed = {.ratio = 5, .sigma = 0.03};
    online o = online_begin(SEARCH_ONE / 2, 0.1);
    run_frames(&o, &even, &r, 100);
    assert_int_equal(o.tunings, 0);
    assert_int_equal(o.share, SEARCH_ONE / 2);
    run_frames(&o, &slowed, &r, 60);
    assert_true(o.tunings >= 1);
    assert_true(replay_off(&slowed, o.share) < 0.08);
    run_frames(&o, &even, &r, 60);
    assert_true(replay_off(&even, o.share) < 0.08);
    online_end(&o);
}

static void a_steady_machine_is_seldom_tuned_again(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    replay_model model = {.ratio = 3, .sigma = 0.05, .spike_chance = 0.03, .spike_most = 3};
    online o = online_begin(SEARCH_ONE / 4, 0.1);
    run_frames(&o, &model, &r, 5000);
    print_message("%u tunings in 5000 frames\n", o.tunings);
    assert_true(o.tunings <= 10);
    assert_true(replay_off(&model, o.share) < 0.1);
    online_end(&o);
}

static void a_trial_costs_no_more_than_was_allowed(void **state)
{
    (void)state;
    static const double ratios[] = {0.1, 0.5, 3, 10};
    for (int i = 0; i < 4; ++i) {
        replay_model even = {.ratio = 1}, moved = {.ratio = ratios[i]};
        online o = online_begin(SEARCH_ONE / 2, 0.1);
        run_frames(&o, &even, NULL, 40);
        assert_true(run_frames(&o, &moved, NULL, 100) <= 1.11);
        assert_true(replay_off(&moved, o.share) < 0.1);
        online_end(&o);
    }
}

static void a_plan_of_one_device_stays(void **state)
{
    (void)state;
    replay_model fast = {.ratio = 4}, slow = {.ratio = 4, .fixed = {0, 0}};
    online o = online_begin(0, 0.1);
    run_frames(&o, &fast, NULL, 50);
    slow.waves[1] = 3;
    run_frames(&o, &slow, NULL, 50);
    assert_int_equal(o.share, 0);
    assert_int_equal(o.tunings, 0);
    online_end(&o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_device_that_slows_down_gets_less_work),
        cmocka_unit_test(a_steady_machine_is_seldom_tuned_again),
        cmocka_unit_test(a_trial_costs_no_more_than_was_allowed),
        cmocka_unit_test(a_plan_of_one_device_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
