// SPDX-License-Identifier: MIT
// When steps count as slower or faster than expected.
#include "support/test.h"

#include "tuner/online.h"

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

TEST_MAIN(NULL, NULL)
