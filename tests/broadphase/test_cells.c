// SPDX-License-Identifier: MIT
// The number of cells along each axis may be compiled into the kernels: the
// pairs are the same, and objects that move never cause a rebuild.
#include "support/test.h"

#include "support/devices.h"

#include "runtime/broadphase/world.h"
#include "runtime/scene/reference.h"

enum { FEW = 400, MANY = 1200 };

static duet_pose poses[MANY];

// Upright cubes in a world whose cells are known.
static duet_world *make_world(uint32_t dims, const float upper[3])
{
    duet_world_def def = devices_def(dims);
    def.rotated = false;
    def.cell = 1.01f;
    def.has_world = true;
    memcpy(def.upper, upper, sizeof def.upper);
    return create_world(&def);
}

static void fill(rng *r, uint32_t n, const float upper[3])
{
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = cube_at(0, 0, 0, 0.5);
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(r, -1.0, upper[k] + 1.0);
    }
}

static void set_variant(duet_world *world, const char *words)
{
    duet_plan plan = plan_of(DUET_MODE_OWN, 0, words, words);
    must(duet_world_set_plan(world, &plan, ERR));
}

// Steps with the first n poses, and gives the kernel that found their cells.
static const kernel *step(duet_world *world, uint32_t n, uint64_t *hash)
{
    duet_result result = step_with(world, DUET_OBJECT_POSES, poses, n);
    *hash = duet_result_get_hash(&result);
    return world->parts[1].kernels.hash;
}

static uint64_t true_hash(uint32_t dims, uint32_t n)
{
    const reference_objects objects = {.dims = dims, .n = n, .poses = poses};
    return reference_hash(&objects, REFERENCE_EACH_WITH_EACH, &(uint64_t){0});
}

TEST(compiled_cells_give_the_same_pairs)
{
    static const char *const searches[] = {"simd cells=fixed", "gpu cells=fixed",
                                           "paper cells=fixed"};
    // powers of two, and others with an axis of one cell
    static const float worlds[][3] = {{16.5f, 8.5f, 4.5f}, {5.9f, 11.5f, 1.0f}};
    rng r = rng_seed(test_seed());
    for (size_t w = 0; w < sizeof worlds / sizeof *worlds; ++w)
        for (uint32_t dims = 2; dims <= 3; ++dims) {
            duet_world *world = make_world(dims, worlds[w]);
            fill(&r, FEW, worlds[w]);
            uint64_t truth = true_hash(dims, FEW), hash;
            for (size_t s = 0; s < sizeof searches / sizeof *searches; ++s) {
                set_variant(world, searches[s]);
                step(world, FEW, &hash);
                if (hash != truth)
                    fail_msg("%s in world %zu, %uD: other pairs", searches[s], w, dims);
            }
        }
}

TEST(only_cells_that_stay_are_compiled_in)
{
    static const float upper[3] = {10, 10, 10};
    rng r = rng_seed(test_seed());
    uint64_t hash;
    fill(&r, MANY, upper);
    duet_world *world = make_world(3, upper);
    set_variant(world, "simd");
    const kernel *free_cells = step(world, FEW, &hash);
    set_variant(world, "simd cells=fixed");
    const kernel *fixed_cells = step(world, FEW, &hash);
    assert_ptr_not_equal(fixed_cells, free_cells);

    // another number of objects in the same world is the same grid
    assert_ptr_equal(step(world, MANY, &hash), fixed_cells);
    assert_int_equal(hash, true_hash(3, MANY));

    // wider objects have wider cells
    poses[7].half_extents[0] = 1.5f;
    assert_ptr_equal(step(world, MANY, &hash), free_cells);
    assert_int_equal(hash, true_hash(3, MANY));
    poses[7].half_extents[0] = 3.0f;
    assert_ptr_equal(step(world, MANY, &hash), free_cells);
}

// Two places, far apart: a grid that was fitted anew would begin elsewhere.
TEST(objects_that_take_turns_keep_their_grids)
{
    static const float upper[3] = {10, 10, 10};
    rng r = rng_seed(test_seed());
    duet_world *world = make_world(3, upper);
    world_fit other = {0};
    double corners[2];
    world->def.has_world = false;
    for (int turn = 0; turn < 6; ++turn) {
        uint64_t hash;
        int place = turn % 2;
        fill(&r, FEW, upper);
        for (int i = 0; i < FEW; ++i)
            poses[i].centre[0] += 1000.0f * (float)place;
        if (turn > 0)
            world_swap_fit(world, &other);
        step(world, FEW, &hash);
        assert_int_equal(hash, true_hash(3, FEW));
        double corner = grid_corner(&world->grid.levels[0], 0, 0);
        if (turn < 2)
            corners[place] = corner;
        assert_true(corner == corners[place]);
    }
    assert_true(corners[1] > corners[0] + 900);
}

TEST(a_word_for_cells_that_there_is_not_is_refused)
{
    duet_world_def def = devices_def(3);
    strcpy(def.plan.variant_b, "simd cells=both");
    must_fail(duet_world_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "variant: cells=both is not possible; expected free or fixed");
}
