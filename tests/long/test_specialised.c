// SPDX-License-Identifier: MIT
// Kernels with a scene's properties compiled in find, bit for bit, the pairs of
// those that leave all of them open: in three dimensions, rotated, hashed, of
// several sizes.
#include "support/test.h"

#include "support/devices.h"

enum { OBJECTS = 600 };

// Features that a scene may have; what it has not is left out of its kernels.
typedef struct scene {
    uint32_t dims;
    bool rotated;
    bool mixed; // sizes over six octaves
    bool flat;  // too few cells along x to be roomy
    duet_pose poses[OBJECTS];
    duet_bounds bounds[OBJECTS];
} scene;

// Centres and half extents are of few bits, so that corners say the same.
static duet_pose random_pose(const scene *s, rng *r)
{
    float half = s->mixed ? (float)(1u << rng_below(r, 7)) / 32 : 0.5f;
    duet_pose p = {.half_extents = {half, half, half}, .rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        double width = k == 0 && s->flat ? 1.0 : s->dims == 3 ? 9.0 : 25.0;
        p.centre[k] = (float)(int)(rng_between(r, 0, width) * 64) / 64;
    }
    if (s->dims == 2)
        p.centre[2] = 0;
    for (int k = s->dims == 2 ? 2 : 0; s->rotated && k < 4; ++k)
        p.rotation[k] = (float)rng_normal(r);
    return p;
}

static void fill(scene *s, rng *r)
{
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        s->poses[i] = random_pose(s, r);
        s->bounds[i] = bounds_of_upright(&s->poses[i]);
    }
}

// The sum over the pairs that such a world finds.
static uint64_t pairs_of(const scene *s, duet_world_def def, const char *words)
{
    duet_result result;
    def.pair = default_pair();
    def.plan = (duet_plan){.mode = DUET_MODE_OWN};
    set_variants(&def.plan, words);
    duet_world *world = create_world(&def);
    must(def.shape == DUET_SHAPE_POSES
             ? duet_world_set_objects(world, DUET_OBJECT_POSES, s->poses, OBJECTS, ERR)
             : duet_world_set_objects(world, DUET_OBJECT_BOUNDS, s->bounds, OBJECTS, ERR));
    must(duet_world_step(world, &result, ERR));
    assert_true(result.pairs > 0);
    return duet_result_get_hash(&result);
}

static void compare(const scene *s, const duet_world_def *def, const char *words, uint64_t general)
{
    if (pairs_of(s, *def, words) != general)
        fail_msg("'%s', %uD, shape %d, rotated %d, of a scene of %uD, rotated %d, mixed %d, flat "
                 "%d: other pairs than the general kernels'",
                 words, def->dims, (int)def->shape, def->rotated, s->dims, s->rotated, s->mixed,
                 s->flat);
}

static void compare_grids(const scene *s, const duet_world_def *def, uint64_t general)
{
    static const char *const variants[] = {
        "simd grid=uniform",
        "simd grid=uniform cells=fixed",
        "simd grid=dense",
        "simd grid=hashed",
        "gpu grid=uniform",
        "gpu grid=uniform cells=fixed",
        "gpu grid=dense",
        "gpu grid=hashed sort=radix",
        "paper",
        "paper cells=fixed",
    };
    for (size_t v = 0; v < sizeof variants / sizeof *variants; ++v)
        compare(s, def, variants[v], general);
}

// A scene's own kernels, those that leave its rotation open, and where there is
// none those that take its corners.
static void compare_all(const scene *s)
{
    duet_world_def def = duet_default_world_def();
    uint64_t general = pairs_of(s, def, "gpu grid=hashed");
    def.dims = s->dims;
    def.rotated = s->rotated;
    compare_grids(s, &def, general);
    if (s->rotated)
        return;
    def.shape = DUET_SHAPE_BOUNDS;
    compare_grids(s, &def, general);
}

TEST(every_combination_of_properties_gives_the_general_kernels_pairs)
{
    rng r = rng_seed(test_seed());
    static scene s;
    for (int properties = 0; properties < 16; ++properties) {
        s.dims = properties & 1 ? 3 : 2;
        s.rotated = properties & 2;
        s.mixed = properties & 4;
        s.flat = properties & 8;
        fill(&s, &r);
        compare_all(&s);
    }
}
