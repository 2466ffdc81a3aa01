// SPDX-License-Identifier: MIT
// The order by cell, and worlds whose objects are kept in about that order.
#include "support/test.h"

#include "support/devices.h"

#include "base/rng.h"
#include "runtime/broadphase/world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CAPACITY = 6000 };

static duet_pose poses[CAPACITY];

// ------------------------------------------------------------ scenes

static duet_pose random_pose(rng *r, double edge)
{
    duet_pose pose = {{0}, {0.5f, 0.5f, 0.5f}, {0}};
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = (float)rng_between(r, 0.0, edge);
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = (float)rng_normal(r);
    return pose;
}

// Unit cubes, about as dense as in the paper.
static void fill_poses(rng *r, uint32_t n, uint32_t dims)
{
    double edge = dims == 3 ? 2.0 * cbrt(n) : 2.0 * sqrt(n);
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = random_pose(r, edge);
}

static duet_world *make_world(const duet_world_def *def)
{
    duet_error err = {0};
    duet_world *world = duet_world_create(def, &err);
    assert_ok(world != NULL, err);
    return world;
}

static void set_poses(duet_world *world, uint32_t n)
{
    duet_error err = {0};
    assert_ok(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, &err), err);
}

static uint32_t *order_of(duet_world *world, uint32_t n)
{
    duet_error err = {0};
    uint32_t *order = NULL, n_ordered = 0;
    assert_ok(duet_world_order(world, &order, &n_ordered, &err), err);
    assert_int_equal(n_ordered, n);
    return order;
}

// ------------------------------------------------------------ the order

static void assert_is_permutation(const uint32_t *order, uint32_t n)
{
    uint8_t *seen = calloc(n + 1, 1);
    for (uint32_t i = 0; i < n; ++i) {
        assert_in_range(order[i], 0, n - 1);
        assert_false(seen[order[i]]);
        seen[order[i]] = 1;
    }
    free(seen);
}

static uint64_t key_of(const duet_world *world, uint32_t id)
{
    const grid_objects objects = world_objects(world);
    const cl_int *cells = world->grid.levels[0].cells.s;
    uint32_t cell[3];
    grid_cell_of(cell, &world->grid, &objects, id);
    return ((uint64_t)cell[2] * (uint32_t)cells[1] + cell[1]) * (uint32_t)cells[0] + cell[0];
}

static void assert_is_by_cell(duet_world *world, uint32_t n)
{
    uint32_t *order = order_of(world, n);
    assert_is_permutation(order, n);
    for (uint32_t i = 1; i < n; ++i) {
        uint64_t before = key_of(world, order[i - 1]), key = key_of(world, order[i]);
        assert_true(before < key || (before == key && order[i - 1] < order[i]));
    }
    duet_free(order);
}

static void the_order_is_a_permutation_by_cell_then_id(void **state)
{
    (void)state;
    static const uint32_t numbers[] = {0, 1, 2, 5, 997, CAPACITY};
    rng r = {test_seed()};
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
            duet_world_def def = duet_default_world_def();
            def.pair = devices;
            def.dims = dims;
            duet_world *world = make_world(&def);
            fill_poses(&r, numbers[i], dims);
            set_poses(world, numbers[i]);
            assert_is_by_cell(world, numbers[i]);
            duet_world_destroy(world);
        }
}

// Mixed sizes have several levels, far crowds a hashed grid, and what is no number a cell too.
static void any_grid_has_an_order(void **state)
{
    (void)state;
    enum { N = 3000 };
    rng r = {test_seed()};
    fill_poses(&r, N, 3);
    for (uint32_t i = 0; i < N; i += 100)
        poses[i].half_extents[0] = 20.0f;
    poses[7].centre[1] = NAN;
    duet_world_def def = duet_default_world_def();
    def.pair = devices;
    duet_world *world = make_world(&def);
    set_poses(world, N);
    assert_is_by_cell(world, N);
    assert_true(world->grid.n_levels > 1);
    duet_world_destroy(world);

    for (uint32_t i = N / 2; i < N; ++i)
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] += 1e6f;
    strcpy(def.plan.variant_a, "simd grid=hashed");
    strcpy(def.plan.variant_b, "simd grid=hashed");
    def.plan.mode = DUET_MODE_OWN;
    world = make_world(&def);
    set_poses(world, N);
    uint32_t *order = order_of(world, N);
    assert_int_equal(world->grid.kind, GRID_HASHED);
    assert_is_permutation(order, N);
    for (uint32_t i = 0; i < N; ++i)
        assert_int_equal(order[i] >= N / 2, i >= N / 2);
    duet_free(order);
    duet_world_destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_order_is_a_permutation_by_cell_then_id),
        cmocka_unit_test(any_grid_has_an_order),
    };
    return cmocka_run_group_tests_name("order", tests, open_devices, close_devices);
}
