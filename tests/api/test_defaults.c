// SPDX-License-Identifier: MIT
// What a def does that nobody has filled in.
#include "support/test.h"

#include "base/rng.h"
#include "runtime/duet.h"
#include "support/devices.h"

#include <string.h>

enum { N = 2000 };

static duet_pose poses[N];

static void scatter(void)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < N; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 12);
    }
}

static void a_default_world_uses_both_devices(void **state)
{
    (void)state;
    duet_device_pair *pair = devices;
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    duet_error err = {0};
    duet_world *world = duet_world_create(&def, &err);
    assert_ok(world, err);
    duet_plan plan = duet_default_plan(pair);
    assert_memory_equal(duet_world_get_plan(world), &plan, sizeof plan);
    assert_in_range(plan.share, 1, DUET_SHARE_ONE - 1);
    scatter();
    duet_result result;
    assert_ok(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, &err), err);
    assert_ok(duet_world_step(world, &result, &err), err);
    for (int d = 0; d < 2; ++d)
        assert_true(result.spans[d].n > 0);
    duet_world_destroy(world);
}

// What a plan says is done, and what it leaves open is the default's.
static void a_plan_may_leave_things_to_the_world(void **state)
{
    (void)state;
    duet_device_pair *pair = devices;
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.plan.mode = DUET_MODE_SLAB;
    strcpy(def.plan.variant_b, "gpu");
    duet_error err = {0};
    duet_world *world = duet_world_create(&def, &err);
    assert_ok(world, err);
    duet_plan usual = duet_default_plan(pair);
    const duet_plan *plan = duet_world_get_plan(world);
    assert_int_equal(plan->mode, DUET_MODE_SLAB);
    assert_int_equal(plan->share, usual.share);
    assert_string_equal(plan->variant_a, usual.variant_a);
    assert_string_equal(plan->variant_b, "gpu");
    usual = duet_default_plan(NULL);
    usual.share = 0;
    assert_ok(duet_world_set_plan(world, &usual, &err), err);
    assert_int_equal(duet_world_get_plan(world)->share, 0);
    assert_string_equal(duet_world_get_plan(world)->variant_a, "simd");
    duet_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_default_world_uses_both_devices),
        cmocka_unit_test(a_plan_may_leave_things_to_the_world),
    };
    return cmocka_run_group_tests(tests, open_devices, close_devices);
}
