// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "profiles/forecast.h"

TEST(a_fit_finds_the_times_it_was_made_from)
{
    rng r = rng_seed(test_seed());
    fit_point points[60];
    for (int i = 0; i < 60; ++i) {
        fit_point p = {.n = exp(rng_between(&r, log(1e4), log(1e7)))};
        p.own = p.n * rng_between(&r, 0.05, 0.95);
        p.occupancy = rng_between(&r, 0.2, 3);
        p.time_ns = 2e5 + 1.5 * p.n + 20 * p.own + 8 * p.own * p.occupancy;
        p.time_ns *= exp(0.02 * rng_normal(&r));
        points[i] = p;
    }
    fit f;
    fit_make(points, 60, &f);
    int outside = 0;
    for (int i = 0; i < 60; ++i) {
        fit_time t = fit_predict(&f, points[i].n, points[i].own, points[i].occupancy);
        outside += fabs(t.ns - points[i].time_ns) > 2 * t.sd_ns;
    }
    assert_in_range(outside, 0, 8);
    assert_true(f.residual > 0.01 && f.residual < 0.04);
    assert_true(fabs(f.terms[2] - 20) < 3 && fabs(f.terms[3] - 8) < 2);
}

// A third of the times is disturbed, by up to the tenfold.
TEST(a_fit_heeds_no_disturbed_times)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 50; ++round) {
        fit_point points[45];
        for (int i = 0; i < 45; ++i) {
            double own = 1e6 * rng_between(&r, 0.1, 0.9);
            points[i] = (fit_point){.n = 1e6, .own = own, .occupancy = 0.66};
            points[i].time_ns = (1e6 + 30 * own) * exp(0.02 * rng_normal(&r));
            if (i % 3 == 0)
                points[i].time_ns *= rng_between(&r, 1, 10);
        }
        fit f;
        fit_make(points, 45, &f);
        assert_true(f.residual < 0.1);
        fit_time t = fit_predict(&f, 1e6, 5e5, 0.66);
        assert_true(fabs(t.ns / 16e6 - 1) < 0.04);
    }
}

TEST(a_fit_knows_what_it_does_not_know)
{
    fit_point points[9]; // points of one size and one occupancy
    for (int i = 0; i < 9; ++i)
        points[i] = (fit_point){
            .n = 1e6, .own = 1e5 * (i + 1), .occupancy = 0.66, .time_ns = 1e6 + 3e6 * (i + 1)};
    fit f;
    fit_make(points, 9, &f);
    fit_time here = fit_predict(&f, 1e6, 3.3e5, 0.66);
    fit_time larger = fit_predict(&f, 1e7, 3.3e6, 0.66);
    fit_time denser = fit_predict(&f, 1e6, 3.3e5, 6);
    assert_true(here.sd_ns / here.ns < 0.05);
    assert_true(larger.sd_ns / larger.ns > 0.05);
    assert_true(denser.sd_ns / denser.ns > 0.2);
}
