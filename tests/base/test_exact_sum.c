// SPDX-License-Identifier: MIT
// Exact sums beside GMP's, in random order and in random parts.
#include "support/test.h"

#include "base/exact_sum.h"

#include <gmp.h>

enum { MOST = 400, BITS = 4096 };

// Any double that is finite: each exponent alike, some below the least normal one.
static double any_double(rng *r)
{
    uint64_t bits = (uint64_t)rng_next(r) << 32 | rng_next(r);
    double x;
    memcpy(&x, &bits, sizeof x);
    return isfinite(x) ? x : 0.0;
}

// Numbers of one scale, each with its negative or near to it, so that sums cancel.
static uint32_t make_numbers(rng *r, double *x)
{
    uint32_t n = 1 + rng_below(r, MOST);
    int kind = (int)rng_below(r, 3), scale = (int)rng_below(r, 1900) - 1000;
    for (uint32_t i = 0; i < n; ++i) {
        x[i] = kind == 0 ? any_double(r) : ldexp(rng_normal(r), scale);
        if (kind == 2 && i % 2 == 1)
            x[i] = rng_below(r, 2) ? -x[i - 1] : -nextafter(x[i - 1], INFINITY);
    }
    return n;
}

static double sum_of(const double *x, uint32_t n)
{
    exact_sum s = {0};
    for (uint32_t i = 0; i < n; ++i)
        exact_sum_add(&s, x[i]);
    return exact_sum_round(&s);
}

// Distance from the sum, as GMP has it without rounding.
static void measure(mpf_t distance, const mpf_t sum, double x)
{
    mpf_set_d(distance, x);
    mpf_sub(distance, distance, sum);
    mpf_abs(distance, distance);
}

static bool is_even(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return !(bits & 1);
}

static void assert_nearest(const mpf_t sum, double x)
{
    mpf_t own, other;
    mpf_init2(own, BITS);
    mpf_init2(other, BITS);
    measure(own, sum, x);
    for (int way = -1; way <= 1; way += 2) {
        double next = nextafter(x, way * INFINITY);
        if (!isfinite(next))
            continue;
        measure(other, sum, next);
        int order = mpf_cmp(own, other);
        if (order > 0 || (order == 0 && !is_even(x)))
            fail_msg("%a is further from the sum than %a", x, next);
    }
    mpf_clear(own);
    mpf_clear(other);
}

TEST(a_sum_is_the_double_nearest_to_that_of_gmp)
{
    double x[MOST];
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 500; ++i) {
        uint32_t n = make_numbers(&r, x);
        mpf_t sum, term;
        mpf_init2(sum, BITS);
        mpf_init2(term, BITS);
        for (uint32_t k = 0; k < n; ++k) {
            mpf_set_d(term, x[k]);
            mpf_add(sum, sum, term);
        }
        double own = sum_of(x, n);
        if (isfinite(own))
            assert_nearest(sum, own);
        else
            assert_true(mpf_cmp_d(sum, 1.79e308) > 0 || mpf_cmp_d(sum, -1.79e308) < 0);
        mpf_clear(sum);
        mpf_clear(term);
    }
}

static void shuffle(rng *r, double *x, uint32_t n)
{
    for (uint32_t i = n; i > 1; --i) {
        uint32_t k = rng_below(r, i);
        double kept = x[i - 1];
        x[i - 1] = x[k];
        x[k] = kept;
    }
}

TEST(order_changes_no_bit)
{
    double x[MOST];
    rng r = rng_seed(test_seed());
    uint32_t plain_differs = 0;
    for (int i = 0; i < 500; ++i) {
        uint32_t n = make_numbers(&r, x);
        double sum = sum_of(x, n), plain = 0, shuffled = 0;
        for (uint32_t k = 0; k < n; ++k)
            plain += x[k];
        shuffle(&r, x, n);
        for (uint32_t k = 0; k < n; ++k)
            shuffled += x[k];
        plain_differs += plain != shuffled;
        double again = sum_of(x, n);
        assert_memory_equal(&sum, &again, sizeof sum);
    }
    assert_true(plain_differs > 50);
}

TEST(few_sums_are_known)
{
    const double tie[] = {1, 0x1p-53}, above[] = {1, 0x1p-53, 0x1p-1074};
    const double odd[] = {1 + 0x1p-52, 0x1p-53}, least[] = {0x1p-1074, 0x1p-1074};
    const double lost[] = {1e308, 1, -1e308}, great[] = {0x1.fffffffffffffp1023, 0x1p970};
    const double nothing[] = {-0.0, 5, -5}, below[] = {-1, -0x1p-53, -0x1p-1074};
    assert_true(sum_of(tie, 2) == 1);
    assert_true(sum_of(above, 3) == 1 + 0x1p-52);
    assert_true(sum_of(below, 3) == -1 - 0x1p-52);
    assert_true(sum_of(odd, 2) == 1 + 0x1p-51);
    assert_true(sum_of(least, 2) == 0x1p-1073);
    assert_true(sum_of(lost, 3) == 1);
    assert_true(sum_of(great, 2) == INFINITY);
    assert_true(sum_of(nothing, 3) == 0 && !signbit(sum_of(nothing, 3)));
    assert_true(sum_of(tie, 0) == 0);
}

TEST(what_is_not_finite_stays_so)
{
    const double up[] = {1, INFINITY}, both[] = {INFINITY, 1, -INFINITY};
    assert_true(sum_of(up, 2) == INFINITY);
    assert_true(isnan(sum_of(both, 3)));
}

// Carries go up long before a limb is full.
TEST(many_of_one_sign_are_summed)
{
    exact_sum s = {0};
    for (uint32_t i = 0; i < 1000000; ++i)
        exact_sum_add(&s, -0x1.fffffffffffffp0);
    assert_true(exact_sum_round(&s) == -0x1.fffffffffffffp0 * 1e6);
}
