// SPDX-License-Identifier: MIT
// What a def does that nobody has filled in.
#include "support/test.h"

#include "support/devices.h"
#include "tuner/duet_tune.h"

enum { N = 2000 };

static duet_pose poses[N];

// Every so many-th is ten times as wide; 0: none is.
static void scatter(int wide)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < N; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3 && wide && i % wide == 0; ++k)
            poses[i].half_extents[k] = 5.0f;
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 12);
    }
}

// Slabs cut grids of one size of cells; whole grids are built where objects differ.
static void step_default(int wide, duet_mode mode)
{
    duet_world_def def = devices_def(3);
    duet_world *world = create_world(&def);
    duet_plan usual = duet_default_plan(default_pair());
    const duet_plan *plan = duet_world_get_plan(world);
    assert_int_equal(plan->share, usual.share);
    assert_string_equal(plan->variant_a, usual.variant_a);
    assert_string_equal(plan->variant_b, usual.variant_b);
    assert_in_range(plan->share, 1, DUET_SHARE_ONE - 1);
    scatter(wide);
    duet_result result = step_with(world, DUET_OBJECT_POSES, poses, N);
    for (int d = 0; d < 2; ++d)
        assert_true(result.spans[d].n > 0);
    assert_int_equal(duet_world_get_plan(world)->mode, mode);
}

TEST(a_default_world_uses_both_devices)
{
    skip_on_one_device();
    step_default(0, DUET_MODE_SLAB);
    step_default(100, DUET_MODE_OWN);
}

// The plan's settings hold, and what it leaves open is the default's.
TEST(a_plan_may_leave_things_to_the_world)
{
    duet_device_pair *pair = default_pair();
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.plan.mode = DUET_MODE_SLAB;
    strcpy(def.plan.variant_b, "gpu");
    duet_world *world = create_world(&def);
    duet_plan usual = duet_default_plan(pair);
    const duet_plan *plan = duet_world_get_plan(world);
    assert_int_equal(plan->mode, DUET_MODE_SLAB);
    assert_int_equal(plan->share, usual.share);
    assert_string_equal(plan->variant_a, usual.variant_a);
    assert_string_equal(plan->variant_b, "gpu");
    duet_plan open = duet_default_plan(NULL);
    open.share = 0;
    must(duet_world_set_plan(world, &open, ERR));
    assert_int_equal(duet_world_get_plan(world)->share, 0);
    assert_string_equal(duet_world_get_plan(world)->variant_a, usual.variant_a);
}

// A def of another kind, or one that nobody filled in, is told by its cookie.
TEST(no_two_defs_have_the_same_cookie)
{
    const int cookies[] = {
        duet_default_device_pair_def().cookie,   duet_default_world_def().cookie,
        duet_default_motion_def().cookie,        duet_default_pair_query_def().cookie,
        duet_default_contact_query_def().cookie, duet_default_tree_def().cookie,
        duet_default_ray_query_def().cookie,     duet_default_sweep_query_def().cookie,
        duet_default_box_query_def().cookie,     duet_default_point_query_def().cookie,
        duet_default_online_def().cookie,        duet_default_tune_def().cookie,
    };
    for (size_t i = 0; i < sizeof cookies / sizeof *cookies; ++i) {
        assert_int_not_equal(cookies[i], 0);
        for (size_t j = 0; j < i; ++j)
            assert_int_not_equal(cookies[i], cookies[j]);
    }
}
