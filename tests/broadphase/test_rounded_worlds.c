// SPDX-License-Identifier: MIT
// Worlds of rounded boxes and of spheres: on any device, at any share, in any grid and mode the
// pairs are the reference's, and what has no radius, or a bad one, is named.
#include "support/devices.h"
#include "support/test.h"

#include "runtime/scene/reference.h"

enum { OBJECTS = 900, EDGE = 7 };

static duet_rounded_box boxes[OBJECTS];
static duet_sphere spheres[OBJECTS];

// ------------------------------------------------------------ scenes

typedef struct scene {
    uint32_t dims;
    duet_shape shape;
    bool rotated;
    bool giants; // some that are ten times as wide
} scene;

// Boxes, capsules, spheres and boxes with a radius, some so that they touch along an axis.
static void fill(const scene *s, rng *r)
{
    double world = s->dims == 3 ? 1.1 * cbrt(OBJECTS) : 1.3 * sqrt(OBJECTS);
    for (int i = 0; i < OBJECTS; ++i) {
        duet_rounded_box b = {.pose.rotation = {0, 0, 0, 1}};
        float scale = s->giants && rng_below(r, 64) == 0 ? 10.0f : 1.0f;
        uint32_t kind = rng_below(r, 4);
        for (int k = 0; k < 3; ++k) {
            double at = rng_between(r, 0, world);
            b.pose.centre[k] = (float)(rng_below(r, 8) ? at : rint(4 * at) / 4);
            bool has_extent = kind == 0 || kind == 1 || (kind == 2 && k == 0);
            b.pose.half_extents[k] = has_extent ? scale * 0.125f * (float)rng_below(r, 4) : 0.0f;
        }
        for (int k = 0; s->rotated && k < 4; ++k)
            b.pose.rotation[k] = (float)rng_normal(r);
        b.radius = kind == 0 ? 0.0f : scale * 0.125f * (float)(1 + rng_below(r, 3));
        boxes[i] = b;
        memcpy(spheres[i].centre, b.pose.centre, sizeof spheres[i].centre);
        spheres[i].radius = 0.5f * scale;
    }
}

static uint64_t true_hash(const scene *s, duet_level level, uint64_t *n)
{
    const reference_objects objects = {.dims = s->dims,
                                       .shape = s->shape,
                                       .n = OBJECTS,
                                       .rounded_boxes = boxes,
                                       .spheres = spheres,
                                       .level = level,
                                       .rotated = s->rotated};
    uint64_t hash = reference_hash(&objects, REFERENCE_EACH_WITH_EACH, n);
    assert_true(hash == reference_hash(&objects, REFERENCE_COLUMNS, n));
    return hash;
}

static duet_world_def def_of(const scene *s, duet_level level, duet_mode mode, uint32_t share,
                             const char *words)
{
    duet_world_def def = devices_def(s->dims);
    def.shape = s->shape;
    def.rotated = s->rotated;
    def.level = level;
    def.plan = plan_of(mode, share, words, words);
    return def;
}

static bool set_objects(duet_world *world, const scene *s, duet_error *err)
{
    bool round = s->shape == DUET_SHAPE_SPHERES;
    return duet_world_set_objects(world, round ? DUET_OBJECT_SPHERES : DUET_OBJECT_ROUNDED_BOXES,
                                  round ? (const void *)spheres : boxes, OBJECTS, err);
}

static void assert_finds_the_reference(const scene *s, duet_level level, duet_mode mode,
                                       uint32_t share, const char *words)
{
    duet_result result;
    uint64_t n;
    uint64_t expected = true_hash(s, level, &n);
    duet_world_def def = def_of(s, level, mode, share, words);
    duet_world *world = create_world(&def);
    must(set_objects(world, s, ERR));
    must(duet_world_step(world, &result, ERR));
    assert_true(n > OBJECTS / 8);
    if (duet_result_get_hash(&result) != expected)
        fail_msg("'%s' in %" PRIu32 "D, shape %d, rotated %d, level %d, mode %d: %" PRIu64
                 " pairs, %" PRIu64 " are the reference's",
                 words, s->dims, (int)s->shape, s->rotated, (int)level, (int)mode, result.pairs, n);
}

static const scene scenes[] = {
    {3, DUET_SHAPE_ROUNDED_BOXES, true, false},  {2, DUET_SHAPE_ROUNDED_BOXES, true, false},
    {3, DUET_SHAPE_ROUNDED_BOXES, false, false}, {3, DUET_SHAPE_SPHERES, false, false},
    {2, DUET_SHAPE_SPHERES, false, false},
};

enum { SCENES = sizeof scenes / sizeof *scenes };

TEST(both_searches_find_the_references_pairs)
{
    uint64_t seed = test_seed();
    rng r = rng_seed(seed);
    print_message("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    for (int i = 0; i < SCENES; ++i) {
        fill(&scenes[i], &r);
        assert_finds_the_reference(&scenes[i], DUET_LEVEL_CERTIFIED, DUET_MODE_SLAB,
                                   DUET_SHARE_ONE / 3, "simd");
        assert_finds_the_reference(&scenes[i], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN,
                                   DUET_SHARE_ONE / 2, "gpu");
    }
}

TEST(grids_modes_and_sorts_make_no_difference)
{
    rng r = rng_seed(test_seed());
    const scene mixed = {3, DUET_SHAPE_ROUNDED_BOXES, true, true};
    fill(&mixed, &r);
    assert_finds_the_reference(&mixed, DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, DUET_SHARE_ONE / 4,
                               "simd grid=dense");
    assert_finds_the_reference(&mixed, DUET_LEVEL_CERTIFIED, DUET_MODE_SHARED, DUET_SHARE_ONE / 4,
                               "gpu grid=hashed sort=radix");
    const scene balls = {3, DUET_SHAPE_SPHERES, false, true};
    assert_finds_the_reference(&balls, DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, 0,
                               "simd pair_search_simd.FUSED=0 grid=hashed");
    assert_finds_the_reference(&balls, DUET_LEVEL_CERTIFIED, DUET_MODE_SLAB, DUET_SHARE_ONE / 2,
                               "gpu FUSED=1 send=packed");
}

TEST(levels_are_those_of_the_reference)
{
    rng r = rng_seed(test_seed());
    fill(&scenes[0], &r);
    for (int l = 0; l < DUET_LEVELS; ++l)
        assert_finds_the_reference(&scenes[0], (duet_level)l, DUET_MODE_OWN, DUET_SHARE_ONE / 3,
                                   "simd");
    assert_finds_the_reference(&scenes[0], DUET_LEVEL_SPHERE, DUET_MODE_OWN, 0, "gpu");
    assert_finds_the_reference(&scenes[3], DUET_LEVEL_SPHERE, DUET_MODE_OWN, 0, "simd");
    assert_finds_the_reference(&scenes[3], DUET_LEVEL_AABB, DUET_MODE_OWN, 0, "gpu");
}

// From where float does not trust itself to where it does, and beyond.
TEST(any_size_has_the_references_pairs)
{
    static const int powers[] = {-130, -75, -45, 45, 95};
    rng r = rng_seed(test_seed());
    for (size_t p = 0; p < sizeof powers / sizeof *powers; ++p) {
        fill(&scenes[0], &r);
        for (int i = 0; i < OBJECTS; ++i) {
            duet_rounded_box *b = &boxes[i];
            b->radius = ldexpf(b->radius, powers[p]);
            spheres[i].radius = ldexpf(spheres[i].radius, powers[p]);
            for (int k = 0; k < 3; ++k) {
                b->pose.half_extents[k] = ldexpf(b->pose.half_extents[k], powers[p]);
                b->pose.centre[k] = spheres[i].centre[k] = ldexpf(b->pose.centre[k], powers[p]);
            }
        }
        assert_finds_the_reference(&scenes[0], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN,
                                   DUET_SHARE_ONE / 2, "simd");
        assert_finds_the_reference(&scenes[3], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN,
                                   DUET_SHARE_ONE / 2, "gpu");
    }
}

TEST(touching_spheres_of_a_lattice_collide)
{
    duet_result result;
    enum { N = EDGE * EDGE * EDGE };
    for (int i = 0; i < N; ++i)
        spheres[i] = (duet_sphere){
            {(float)(i % EDGE), (float)(i / EDGE % EDGE), (float)(i / EDGE / EDGE)}, 0.5f};
    duet_world_def def = def_of(&scenes[3], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, 0, "simd");
    duet_world *world = create_world_of(&def, DUET_OBJECT_SPHERES, spheres, N);
    must(duet_world_step(world, &result, ERR));
    assert_int_equal(result.pairs, 3 * EDGE * EDGE * (EDGE - 1));
}

// ------------------------------------------------------------ refused

TEST(bad_radii_are_named)
{
    const float bad[] = {-1.0f, NAN, INFINITY};
    duet_result result;
    rng r = rng_seed(test_seed());
    for (int i = 0; i < SCENES; i += 3) {
        fill(&scenes[i], &r);
        duet_world_def def = def_of(&scenes[i], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, 0, "simd");
        duet_world *world = create_world(&def);
        for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
            boxes[17].radius = spheres[17].radius = bad[k];
            must(set_objects(world, &scenes[i], ERR));
            must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "17");
        }
    }
}

static void refuse(duet_world_def def, const char *why)
{
    must_fail(duet_world_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, why);
}

TEST(what_knows_no_radii_says_so)
{
    duet_world_def def = def_of(&scenes[3], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, 0, "simd");
    duet_world_def other = def;
    other.pose_form = DUET_POSE_COMPACT;
    refuse(other, "pose_form is for poses; expected DUET_POSE_WHOLE for spheres");
    other = def;
    other.origin_edge = 1.0f;
    refuse(other, "origin cells are for poses; expected an origin_edge of 0 for spheres");
    other = def_of(&scenes[0], DUET_LEVEL_CERTIFIED, DUET_MODE_OWN, 0, "paper");
    refuse(other, "the paper's search knows no rounded boxes");
    duet_tree_def tree = duet_default_tree_def();
    tree.pair = default_pair();
    duet_world *world = create_world(&def);
    must_fail(duet_world_set_objects(world, DUET_OBJECT_POSES, boxes, 1, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "the world was made for spheres, not for poses");
    duet_scene *made = kept(duet_scene_create(DUET_OBJECT_SPHERES, spheres, 3, 3, 0, ERR));
    duet_motion_def motion = duet_scene_motion_def(made, default_pair());
    motion.wants = DUET_EFFECT_CONTACT;
    duet_motion *m = kept(duet_motion_create_from_scene(&motion, made, NULL, ERR));
    tree.shape = DUET_SHAPE_POSES;
    duet_tree *of_bodies = kept(duet_tree_create(&tree, ERR));
    must_fail(duet_tree_set_motion(of_bodies, m, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "the motion's bodies have radii; the tree is of poses, expected "
                                   "one of rounded boxes");
}
