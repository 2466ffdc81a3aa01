// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "runtime/base/rng.h"
#include "runtime/narrow.h"

#include <math.h>

static duet_pose cube_at(float x, float y, float z)
{
    return (duet_pose){{x, y, z}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
}

static duet_pose random_box(rng *r, double spread)
{
    duet_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.centre[i] = (float)rng_between(r, 0, spread);
        pose.half[i] = (float)rng_between(r, 0.1, 1);
    }
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = (float)rng_normal(r);
    return pose;
}

static void identical_boxes_collide(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 1000; ++i) {
        duet_pose a = random_box(&r, 1);
        assert_true(narrow_decide(&a, &a, 3));
        assert_true(narrow_exact(&a, &a, 3));
        assert_true(narrow_decide(&a, &a, 2));
    }
}

static void touching_cubes_collide_and_one_ulp_apart_do_not(void **state)
{
    (void)state;
    duet_pose a = cube_at(1, 2, 3), b = cube_at(2, 2, 3);
    assert_int_equal(narrow_double(&a, &b, 3), NARROW_COLLIDING);
    assert_true(narrow_exact(&a, &b, 3));
    b.centre[0] = nextafterf(2, 3);
    assert_int_equal(narrow_double(&a, &b, 3), NARROW_SEPARATED);
    assert_false(narrow_exact(&a, &b, 3));
}

static void double_never_contradicts_exact(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 10000; ++i) {
        duet_pose a = random_box(&r, 2), b = random_box(&r, 2);
        uint32_t dims = 2 + (uint32_t)i % 2;
        narrow_verdict verdict = narrow_double(&a, &b, dims);
        if (verdict != NARROW_UNDECIDED)
            assert_int_equal(verdict == NARROW_COLLIDING, narrow_exact(&a, &b, dims));
    }
}

static void float_leaves_few_ordinary_pairs_undecided_and_never_errs(void **state)
{
    (void)state;
    enum { N = 200000 };
    rng r = rng_seed(test_seed());
    int undecided = 0;
    for (int i = 0; i < N; ++i) {
        duet_pose a = random_box(&r, 2), b = random_box(&r, 2);
        narrow_verdict verdict = narrow_float(&a, &b, 3, true);
        undecided += verdict == NARROW_UNDECIDED;
        if (verdict != NARROW_UNDECIDED)
            assert_int_equal(verdict == NARROW_COLLIDING, narrow_decide(&a, &b, 3));
    }
    assert_in_range(undecided, 0, N / 10000);
}

static void a_pose_that_is_no_box_collides_with_nothing(void **state)
{
    (void)state;
    duet_pose good = cube_at(0, 0, 0);
    duet_pose bad[] = {good, good, good, good};
    bad[0].centre[0] = NAN;
    bad[1].half[1] = -1;
    bad[2].rotation[3] = 0;
    bad[3].centre[2] = INFINITY;
    for (int i = 0; i < 4; ++i) {
        assert_false(duet_poses_collide(&good, &bad[i], 3));
        assert_false(narrow_exact(&bad[i], &good, 3));
    }
    assert_true(duet_poses_collide(&good, &bad[3], 2));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(identical_boxes_collide),
        cmocka_unit_test(touching_cubes_collide_and_one_ulp_apart_do_not),
        cmocka_unit_test(double_never_contradicts_exact),
        cmocka_unit_test(float_leaves_few_ordinary_pairs_undecided_and_never_errs),
        cmocka_unit_test(a_pose_that_is_no_box_collides_with_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
