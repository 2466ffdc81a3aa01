// SPDX-License-Identifier: MIT
// The one property at full size: the shipped scenes, a million boxes of the
// paper's and a hundred thousand of the others, under every mode, search and
// share, against the plain C reference.
#include "support/test.h"

// Bytes that a device may hold for an object, and for a pair.
enum { OBJECT_BYTES = 200, PAIR_BYTES = 16 };

static void check_step(duet_world *world, const duet_plan *plan, uint64_t pairs, uint64_t hash)
{
    duet_result result;
    must(duet_world_set_plan(world, plan, ERR));
    must(duet_world_step(world, &result, ERR));
    if (result.pairs != pairs || duet_result_get_hash(&result) != hash)
        fail_msg("'%s', mode %s, share %u: %" PRIu64 " pairs, the reference has %" PRIu64,
                 plan->variant_a, duet_mode_name(plan->mode), plan->share, result.pairs, pairs);
    for (int side = 0; side < 2; ++side)
        if (result.objects >= 1000000)
            assert_in_range(result.bytes[side], 0,
                            OBJECT_BYTES * (uint64_t)result.objects + PAIR_BYTES * pairs);
}

static void check_scene(const char *name, const char *n)
{
    static const uint32_t shares[] = {0, 1, 6554, 32768, 58982, DUET_SHARE_ONE};
    static const char *const variants[] = {"auto", "paper"};
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.lua", getenv("DUET_TEST_SCENES"), name);
    duet_setting settings[] = {{"n", n}};
    duet_scene *scene = kept(duet_scene_load(path, settings, 1, ERR));
    duet_pair *expected = NULL;
    uint64_t pairs = 0;
    must(duet_reference(scene, DUET_LEVEL_CERTIFIED, &expected, &pairs, ERR));
    uint64_t hash = duet_pairs_hash(expected, pairs);
    duet_free(expected);
    print_message("%s, %s objects: %" PRIu64 " pairs, hash %016" PRIx64 "\n", name, n, pairs, hash);

    duet_device_pair *pair = kept(duet_device_pair_open(NULL, ERR));
    duet_world_def def = duet_scene_world_def(scene, pair);
    duet_world *world = kept(duet_world_create(&def, ERR));
    must(duet_world_set_scene(world, scene, ERR));
    for (int v = 0; v < 2; ++v)
        for (duet_mode mode = DUET_MODE_SHARED; mode <= DUET_MODE_SLAB; ++mode)
            for (size_t s = 0; s < sizeof shares / sizeof shares[0]; ++s) {
                duet_plan plan = {.share = shares[s], .mode = mode};
                snprintf(plan.variant_a, sizeof plan.variant_a, "%s", variants[v]);
                snprintf(plan.variant_b, sizeof plan.variant_b, "%s", variants[v]);
                check_step(world, &plan, pairs, hash);
            }
}

TEST(a_million_boxes_of_the_paper)
{
    check_scene("paper", "1000000");
}

TEST(a_hundred_thousand_in_2d)
{
    check_scene("paper2d", "100000");
}

TEST(a_hundred_thousand_in_clusters)
{
    check_scene("clustered", "100000");
}

TEST(a_hundred_thousand_of_mixed_sizes)
{
    check_scene("mixed", "100000");
}

TEST(a_hundred_thousand_on_planes)
{
    check_scene("planes", "100000");
}
