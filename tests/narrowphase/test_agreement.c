// SPDX-License-Identifier: MIT
// Each level of accuracy is one set of pairs: its reference's, bit by bit, on
// both devices, at any share, by any search.
#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/test.h"

#include "runtime/scene/reference.h"

// The first of the hard classes are of ordinary sizes.
enum { OBJECTS = 900, HARD = 100, HARD_CLASSES = 10 };

// The last one is a GPU's, with groups that share their work.
static const char *const searches[] = {
    "simd",
    "simd grid=hashed",
    "simd pair_search_simd.FUSED=0",
    "gpu",
    "paper",
    "gpu pair_search_gpu.FUSED=1 pair_search_gpu.WG=64 pair_search_gpu.PER_ITEM=4",
};

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE};

typedef struct crowd {
    uint32_t dims;
    bool rotated;
    uint32_t n;
    duet_pose poses[OBJECTS];
} crowd;

static duet_pose random_pose(rng *r, double width, bool rotated)
{
    duet_pose p = {.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        double at = rng_between(r, -width, width);
        p.centre[k] = (float)(rng_below(r, 2) ? at : (double)(int)at);
        p.half_extents[k] = rng_below(r, 2) ? 0.5f : (float)rng_between(r, 0, 0.5);
    }
    // every other one is nearly upright, where textbooks go wrong
    double turn = rng_below(r, 2) ? 1.0 : 1e-6;
    for (int k = 0; rotated && k < 3; ++k)
        p.rotation[k] = (float)(turn * rng_normal(r));
    return p;
}

// A crowd, and pairs that are hard, in any order.
static void fill(crowd *c, rng *r)
{
    c->n = OBJECTS;
    for (uint32_t i = 0; i < c->n; ++i)
        c->poses[i] = random_pose(r, 4.0, c->rotated);
    for (uint32_t i = 0; c->rotated && i < HARD; ++i) {
        hard_pair pair = hard_classes[rng_below(r, HARD_CLASSES)].make(r, c->dims);
        c->poses[rng_below(r, OBJECTS)] = pair.a;
        c->poses[rng_below(r, OBJECTS)] = pair.b;
    }
}

static reference_found reference_of(const crowd *c, duet_level level)
{
    reference_objects objects = {.dims = c->dims,
                                 .shape = DUET_SHAPE_POSES,
                                 .n = c->n,
                                 .poses = c->poses,
                                 .level = level,
                                 .rotated = c->rotated};
    return found_by(&objects, REFERENCE_EACH_WITH_EACH);
}

static duet_world *open_world(duet_device_pair *pair, const crowd *c)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.dims = c->dims;
    def.rotated = c->rotated;
    duet_world *world = create_world_of(&def, DUET_OBJECT_POSES, c->poses, c->n);
    return world;
}

// B searches in each way. A's kernels are compiled apart from B's, which takes most of the
// test's time: beside B it searches in one way, and alone in another at each level.
static void step(duet_world *world, const crowd *c, duet_level level, const reference_found *truth,
                 const char *search, uint32_t share)
{
    duet_plan plan =
        plan_of(DUET_MODE_OWN, share, share == DUET_SHARE_ONE ? search : "gpu", search);
    duet_result result = step_by(world, &plan);
    if (duet_result_get_hash(&result) != duet_pairs_hash(truth->pairs, truth->n))
        fail_msg("%uD rotated %d %s, %s at %" PRIu32 ": %" PRIu64 " pairs; expected the %" PRIu64
                 " of the reference",
                 c->dims, c->rotated, duet_level_get_info(level)->name, search, share, result.pairs,
                 truth->n);
    if (level != DUET_LEVEL_CERTIFIED && c->rotated)
        assert_int_equal(result.undecided, 0);
    if (result.candidates < result.pairs)
        fail_msg("%s, %s at %" PRIu32 ": %" PRIu64 " candidates of %" PRIu64 " pairs",
                 duet_level_get_info(level)->name, search, share, result.candidates, result.pairs);
}

static void try_levels(duet_device_pair *pair, const crowd *c)
{
    duet_world *world = open_world(pair, c);
    for (int l = 0; l < DUET_LEVELS; ++l) {
        duet_level level = (duet_level)l;
        reference_found truth = reference_of(c, level);
        must(duet_world_set_level(world, level, ERR));
        for (size_t s = 0; s < sizeof searches / sizeof *searches; ++s) {
            if (level == DUET_LEVEL_AABB && strstr(searches[s], "FUSED="))
                continue; // there is no test to fuse
            if (!test_takes((uint64_t)l + s + c->dims + c->rotated, 6))
                continue;
            for (size_t k = 0; k < sizeof shares / sizeof *shares; ++k)
                if (shares[k] < DUET_SHARE_ONE || s == (size_t)l)
                    step(world, c, level, &truth, searches[s], shares[k]);
        }
    }
}

TEST(devices_find_each_levels_reference)
{
    rng r = rng_seed(test_seed());
    static crowd c;
    for (c.dims = 2; c.dims <= 3; ++c.dims)
        for (int rotated = 0; rotated < 2; ++rotated) {
            c.rotated = rotated;
            fill(&c, &r);
            try_levels(default_pair(), &c);
        }
}

TEST(a_level_that_there_is_not_is_refused)
{
    duet_world_def world = devices_def(3);
    world.level = (duet_level)DUET_LEVELS;
    must_fail(duet_world_create(&world, ERR), DUET_STATUS_BAD_ARGUMENT, "");
}
