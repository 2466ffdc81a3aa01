// SPDX-License-Identifier: MIT
// Boxes in origin cells in every mode, search, sort and grid, and at every level.
#include "support/test.h"

#include "support/agreement.h"
#include "support/devices.h"
#include "support/large.h"

static uint64_t check_cloud(const duet_world_def *def, double at, double most, uint64_t seed)
{
    rng r = rng_seed(seed);
    const double where[3] = {at, -at, at / 2};
    scatter_large(0, 300, where, def->dims == 3 ? 6 : 14, most, def->rotated, &r);
    return agreement_check(def, large_poses, 300);
}

TEST(a_cloud_far_away_has_the_pairs_of_the_one_at_0)
{
    uint64_t seed = test_seed();
    const duet_world_def defs[] = {large_def(2, true), large_def(3, false), large_def(3, true)};
    for (int i = 0; i < 3; ++i) {
        uint64_t here = check_cloud(&defs[i], 0, 1, seed);
        assert_true(here > 300);
        assert_int_equal(check_cloud(&defs[i], 1e7, 1, seed), here);
    }
}

TEST(boxes_of_many_sizes_far_away_are_all_found)
{
    uint64_t seed = test_seed();
    duet_world_def def = large_def(3, true);
    assert_int_equal(check_cloud(&def, -1e7, 40, seed), check_cloud(&def, 0, 40, seed));
}

TEST(clouds_at_both_ends_of_a_world_are_searched)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = large_def(3, true);
    scatter_large(0, 200, (double[]){-1e7, 1e7, 0}, 5, 2, true, &r);
    scatter_large(200, 200, (double[]){1e7, -1e7, 1e3}, 5, 2, true, &r);
    assert_true(agreement_check(&def, large_poses, 400) > 200);
    def.has_world = true; // one of them outside
    for (int k = 0; k < 3; ++k) {
        def.lower[k] = -1.5e7f;
        def.upper[k] = 1e6f;
    }
    assert_true(agreement_check(&def, large_poses, 400) > 200);
}

TEST(every_level_finds_its_reference_s_pairs_far_away)
{
    rng r = rng_seed(test_seed());
    scatter_large(0, 300, (double[]){1e7, -1e7, 3}, 6, 2, true, &r);
    duet_scene *scene =
        kept(duet_scene_create(DUET_OBJECT_LARGE_POSES, large_poses, 300, 3, LARGE_EDGE, ERR));
    duet_world_def def = duet_scene_world_def(scene, default_pair());
    duet_world *world = create_world(&def);
    must(duet_world_set_scene(world, scene, ERR));
    const char *const variants[] = {"gpu", "simd"};
    for (int l = 0; l < DUET_LEVELS; ++l) {
        set_variants(&def.plan, variants[l % 2]);
        must(duet_world_set_plan(world, &def.plan, ERR));
        must(duet_world_set_level(world, (duet_level)l, ERR));
        assert_step_finds(world, known_pairs_of_scene(scene, (duet_level)l));
    }
}
