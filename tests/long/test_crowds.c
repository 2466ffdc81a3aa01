// SPDX-License-Identifier: MIT
// More objects in a cell than 16 bits count, and more pairs than 31 and 32 bits
// do. The pairs themselves, 17 and 34 GB, are not kept: devices count on where a
// list has no space, and a step that may not keep them says how many they are.
#include "support/test.h"

#include "support/devices.h"

// Upright cubes in one cell of edge 1.
static duet_world *open_world(duet_pose *poses, uint32_t n, float half, uint64_t max_pairs)
{
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = (duet_pose){{0}, {half, half, half}, {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 10.25, 10.75);
    }
    duet_world_def def = devices_def(3);
    def.plan = duet_default_plan(default_pair());
    def.rotated = false;
    def.cell = 1;
    def.has_world = true;
    memcpy(def.upper, (float[]){20, 20, 20}, sizeof def.upper);
    def.max_pairs = max_pairs;
    duet_world *world = create_world_of(&def, DUET_OBJECT_POSES, poses, n);
    return world;
}

static duet_pose *room_for(uint32_t n)
{
    return test_alloc(n * sizeof(duet_pose));
}

TEST(none_of_65537_objects_in_a_cell_is_missed)
{
    enum { N = 65537 };
    static const char *const variants[] = {"auto", "gpu"};
    duet_pose *poses = room_for(N);
    duet_world *world = open_world(poses, N, 0.002f, 0);
    const known_pairs truth = known_pairs_of(DUET_OBJECT_POSES, poses, N, 3);
    assert_true(truth.n > 1000);
    for (int v = 0; v < 2; ++v) {
        duet_plan plan = *duet_world_get_plan(world);
        set_variants(&plan, variants[v]);
        const duet_result result = step_by(world, &plan);
        assert_true(result.cell >= 1);
        assert_found(&result, truth);
    }
}

// All n objects overlap each other, and B alone counts the pairs.
static void expect_too_many(uint32_t n, uint64_t max_pairs, const char *says)
{
    duet_result result;
    duet_pose *poses = room_for(n);
    duet_world *world = open_world(poses, n, 0.4f, max_pairs);
    duet_plan plan = *duet_world_get_plan(world);
    plan.share = 0;
    must(duet_world_set_plan(world, &plan, ERR));
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_TOO_MANY, says);
}

TEST(more_pairs_than_31_bits_count_are_counted)
{
    expect_too_many(65537, 1000000, "2147516416 pairs on "); // 65537 * 65536 / 2
}

TEST(more_pairs_than_32_bits_count_are_counted)
{
    expect_too_many(92683, 1000000, "4295022903 pairs"); // 92683 * 92682 / 2
    expect_too_many(92683, 0, ", more than the 4294967295 that one device can list");
}
