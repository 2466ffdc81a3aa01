// SPDX-License-Identifier: MIT
// Where grids lose pairs or find them twice, through the public API.
#include "support/test.h"

#include "support/agreement.h"
#include "support/devices.h"
#include "support/hard_pairs.h"

#include <float.h>

enum { CAPACITY = 20000 };

static duet_pose poses[CAPACITY];
static duet_bounds bounds[CAPACITY];

// ------------------------------------------------------------ scenes

static duet_world_def def_of(uint32_t dims)
{
    duet_world_def def = devices_def(dims);
    return def;
}

// Upright cubes with cells of one edge in a world of the given size.
static duet_world_def def_of_cells(float x, float y, float z)
{
    duet_world_def def = def_of(3);
    def.rotated = false;
    def.cell = 1;
    def.has_world = true;
    memcpy(def.upper, (float[]){x, y, z}, sizeof def.upper);
    return def;
}

static duet_pose scattered(rng *r, double from, double to, double half)
{
    return cube_at(rng_between(r, from, to), rng_between(r, from, to), rng_between(r, from, to),
                   half);
}

static void scatter(uint32_t n, rng *r, double from, double to, double half)
{
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = scattered(r, from, to, half);
        turn_at_random(&poses[i], r);
    }
}

// ------------------------------------------------------------ borders

TEST(centres_on_cell_borders_meet_all_neighbours)
{
    duet_world_def def = def_of_cells(4, 4, 4);
    uint32_t n = 0;
    for (int x = 0; x <= 8; ++x)
        for (int y = 0; y <= 8; ++y)
            for (int z = 0; z <= 8; ++z)
                poses[n++] = cube_at(x * 0.5, y * 0.5, z * 0.5, 0.25);
    assert_int_equal(agreement_check(&def, poses, n), (25 * 25 * 25 - 9 * 9 * 9) / 2);
    for (uint32_t i = 0; i < n; ++i)
        poses[i].half_extents[0] = poses[i].half_extents[1] = poses[i].half_extents[2] = 0.5f;
    agreement_check(&def, poses, n);
}

TEST(objects_on_and_an_ulp_beyond_the_world_s_faces_are_found)
{
    duet_world_def def = def_of_cells(8, 8, 8);
    const float along[] = {0, -FLT_TRUE_MIN, 8, nextafterf(8, 9), nextafterf(8, 7), 4};
    uint32_t n = 0;
    for (int x = 0; x < 6; ++x)
        for (int y = 0; y < 6; ++y)
            for (int z = 0; z < 6; ++z)
                poses[n++] = cube_at(along[x], along[y], along[z], 0.5);
    assert_true(agreement_check(&def, poses, n) > 0);
}

TEST(negative_coordinates_are_rounded_down)
{
    duet_world_def def = def_of_cells(2, 2, 2);
    for (int k = 0; k < 3; ++k)
        def.lower[k] = -2;
    const double along[] = {-1.5, -1.0, -0.3, 0.3, 1.0};
    uint32_t n = 0;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y)
            for (int z = 0; z < 5; ++z)
                poses[n++] = cube_at(along[x], along[y], along[z], 0.45);
    assert_true(agreement_check(&def, poses, n) > 0);
}

TEST(objects_far_outside_the_world_are_found)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of_cells(5, 5, 5);
    uint32_t n = 0;
    for (int side = 0; side < 27; ++side)
        for (int i = 0; i < 20; ++i) {
            poses[n] = scattered(&r, 0, 3, 0.5);
            poses[n].centre[0] += 1000.0f * (float)(side % 3 - 1);
            poses[n].centre[1] += 1000.0f * (float)(side / 3 % 3 - 1);
            poses[n++].centre[2] += 1000.0f * (float)(side / 9 - 1);
        }
    assert_true(agreement_check(&def, poses, n) > 27);
}

TEST(zeros_of_either_sign_are_alike)
{
    duet_world_def def = def_of_cells(2, 2, 2);
    for (uint32_t i = 0; i < 64; ++i) {
        poses[i] = cube_at(i & 1 ? -0.0 : 0.0, i & 2 ? -0.0 : 1.0, i & 4 ? 0.0 : -0.0, 0.5);
        poses[i].rotation[0] = i & 8 ? -0.0f : 0.0f;
    }
    assert_int_equal(agreement_check(&def, poses, 64), 64 * 63 / 2);
}

// ------------------------------------------------------------ the cell's edge

TEST(turned_cubes_with_a_cell_of_their_edge_are_refused_or_widened)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of_cells(10, 10, 10);
    def.rotated = true;
    def.cell_fixed = true;
    scatter(500, &r, 0, 10, 0.5);
    duet_result result;
    duet_world *world = create_world_of(&def, DUET_OBJECT_POSES, poses, 500);
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_CELL_TOO_SMALL, "");
    def.cell_fixed = false;
    assert_true(agreement_check(&def, poses, 500) > 0);
}

TEST(a_cell_an_ulp_below_the_largest_object_loses_nothing)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of_cells(10, 10, 10);
    for (uint32_t i = 0; i < 800; ++i)
        poses[i] = scattered(&r, 0, 10, 0.5);
    def.cell = nextafterf(1, 0);
    assert_true(agreement_check(&def, poses, 800) > 0);
}

TEST(grids_of_one_to_three_cells_an_axis_find_each_pair_once)
{
    rng r = rng_seed(test_seed());
    const float dims[][3] = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {1, 40, 1}, {2, 1, 40}, {40, 3, 2}};
    for (size_t d = 0; d < sizeof dims / sizeof *dims; ++d) {
        duet_world_def def =
            def_of_cells(1.01f * dims[d][0], 1.01f * dims[d][1], 1.01f * dims[d][2]);
        for (uint32_t i = 0; i < 300; ++i)
            poses[i] = cube_at(rng_between(&r, 0, dims[d][0]), rng_between(&r, 0, dims[d][1]),
                               rng_between(&r, 0, dims[d][2]), 0.5);
        assert_true(agreement_check(&def, poses, 300) > 0);
    }
}

TEST(dims_that_are_no_power_of_two_lose_nothing)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(2);
    scatter(5000, &r, 0, 127, 0.5);
    assert_true(agreement_check(&def, poses, 5000) > 0);
}

TEST(a_world_of_more_cells_than_32_bits_count_is_no_trouble)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of_cells(1e9f, 1e9f, 1e9f);
    for (uint32_t i = 0; i < 2000; ++i)
        poses[i] = scattered(&r, 0, 1e4, 500 * rng_unit(&r));
    for (uint32_t i = 0; i < 1000; ++i)
        poses[i] = cube_at(1e6 * (i / 2), 3e5 * (i / 2), 9e8 * (i % 4 / 2), 0.5);
    assert_true(agreement_check(&def, poses, 2000) >= 500);
}

TEST(memory_follows_the_objects_and_not_the_world)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of_cells(1e9f, 1e9f, 1e9f);
    for (uint32_t i = 0; i < CAPACITY; ++i)
        poses[i] = scattered(&r, 0, 1e9, 0.5);
    duet_result result;
    duet_world *world = create_world_of(&def, DUET_OBJECT_POSES, poses, CAPACITY);
    must(duet_world_step(world, &result, ERR));
    assert_true(result.bytes[0] < 1000 * CAPACITY);
    assert_true(result.bytes[1] < 1000 * CAPACITY);
}

// ------------------------------------------------------------ crowds

TEST(all_objects_in_one_place_make_all_pairs)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    const uint32_t counts[] = {257, 513};
    for (size_t i = 0; i < 2; ++i) {
        scatter(counts[i], &r, 0, 1e-3, 0.5);
        uint64_t all = (uint64_t)counts[i] * (counts[i] - 1) / 2;
        assert_int_equal(agreement_check(&def, poses, counts[i]), all);
    }
}

TEST(many_small_objects_in_one_cell_are_told_apart)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    for (uint32_t i = 0; i < 4100; ++i)
        poses[i] = scattered(&r, 0, 1, 0.01);
    poses[4100] = cube_at(5, 5, 5, 1);
    assert_true(agreement_check(&def, poses, 4101) > 0);
}

TEST(identical_boxes_on_a_lattice_touch_their_neighbours)
{
    duet_world_def def = def_of(3);
    for (uint32_t i = 0; i < 4096; ++i)
        poses[i] = cube_at(i % 16, i / 16 % 16, i / 256, 0.5);
    assert_int_equal(agreement_check(&def, poses, 4096), (46 * 46 * 46 - 4096) / 2);
    def.rotated = false;
    agreement_check(&def, poses, 4096);
}

TEST(objects_on_a_line_or_a_plane_are_like_any_others)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    for (int flat = 1; flat < 7; ++flat) {
        for (uint32_t i = 0; i < 700; ++i) {
            poses[i] = scattered(&r, 0, 60, 0.5);
            turn_at_random(&poses[i], &r);
            for (int k = 0; k < 3; ++k)
                if (flat >> k & 1)
                    poses[i].centre[k] = 3;
        }
        assert_true(agreement_check(&def, poses, 700) > 0);
    }
}

TEST(one_giant_meets_exactly_all_others)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    scatter(1999, &r, 0, 1000, 0.01);
    poses[1999] = cube_at(500, 500, 500, 600);
    assert_true(agreement_check(&def, poses, 2000) >= 1999);
}

TEST(sizes_of_one_to_a_thousand_lose_nothing)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    for (uint32_t i = 0; i < 1500; ++i) {
        poses[i] = scattered(&r, 0, 50, i % 2 ? 0.005 : 5);
        turn_at_random(&poses[i], &r);
    }
    assert_true(agreement_check(&def, poses, 1500) > 0);
}

TEST(points_are_objects_too)
{
    duet_world_def def = def_of(3);
    for (uint32_t i = 0; i < 300; ++i)
        poses[i] = cube_at(i % 10, i / 10 % 10, 0, 0);
    assert_int_equal(agreement_check(&def, poses, 300), 100 * 3);
    for (uint32_t i = 0; i < 300; ++i)
        poses[i] = cube_at(7, 7, 7, 0);
    assert_int_equal(agreement_check(&def, poses, 300), 300 * 299 / 2);
}

// ------------------------------------------------------------ numbers of objects

TEST(scenes_of_any_small_number_of_objects_are_whole)
{
    rng r = rng_seed(test_seed());
    const uint32_t counts[] = {0, 1, 2, 3, 7, 31, 61, 63, 64, 65, 127, 257, 1021};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        duet_world_def def = def_of(2 + i % 2);
        scatter(counts[i], &r, 0, cbrt(counts[i]), 0.5);
        agreement_check(&def, poses, counts[i]);
    }
}

static duet_world *open_world(const duet_world_def *def, uint32_t n)
{
    duet_world *world = create_world_of(def, DUET_OBJECT_POSES, poses, n);
    return world;
}

TEST(a_limit_of_pairs_holds_to_the_last_one)
{
    for (uint32_t i = 0; i < 200; ++i)
        poses[i] = cube_at(0, 0, 0, 0.5);
    duet_world_def def = def_of(3);
    for (int below = 0; below < 2; ++below) {
        def.max_pairs = 200 * 199 / 2 - (uint64_t)below;
        duet_result result;
        duet_world *world = open_world(&def, 200);
        if (below)
            must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_TOO_MANY, "19900");
        else
            must(duet_world_step(world, &result, ERR));
    }
}

TEST(a_world_steps_on_as_its_pairs_become_more_and_fewer)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    duet_world *world = open_world(&def, 0);
    const uint32_t counts[] = {10, 1500, 3, 0, 700, 1501};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        duet_result result;
        scatter(counts[i], &r, 0, 0.1, 0.5);
        must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, counts[i], ERR));
        must(duet_world_step(world, &result, ERR));
        uint64_t n = counts[i];
        assert_int_equal(result.pairs, n > 0 ? n * (n - 1) / 2 : 0);
    }
}

// ------------------------------------------------------------ bad objects

TEST(one_nan_among_thousands_changes_nothing_else)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    scatter(3000, &r, 0, 12, 0.5);
    poses[1234].centre[1] = 1e9f;
    duet_result clean, kept;
    duet_world *world = open_world(&def, 3000);
    must(duet_world_step(world, &clean, ERR));
    uint64_t pairs = clean.pairs, hash = duet_result_get_hash(&clean);
    poses[1234].centre[1] = NAN;
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, 3000, ERR));
    must_fail(duet_world_step(world, &kept, ERR), DUET_STATUS_BAD_OBJECT, "1234");
    def.keep_bad = true;
    world = open_world(&def, 3000);
    must(duet_world_step(world, &kept, ERR));
    assert_int_equal(kept.bad, 1);
    assert_int_equal(kept.first_bad, 1234);
    assert_int_equal(kept.pairs, pairs);
    assert_int_equal(duet_result_get_hash(&kept), hash);
}

TEST(each_kind_of_bad_pose_is_named)
{
    for (int kind = 0; kind < 6; ++kind) {
        for (uint32_t i = 0; i < 10; ++i)
            poses[i] = cube_at(2 * i, 0, 0, 0.5);
        duet_pose *bad = &poses[7];
        bad->centre[0] = kind == 0 ? INFINITY : bad->centre[0];
        bad->centre[2] = kind == 1 ? -INFINITY : 0;
        bad->half_extents[1] = kind == 2 ? -1 : kind == 3 ? NAN : 0.5f;
        bad->rotation[3] = kind == 4 ? 0 : kind == 5 ? NAN : 1;
        duet_world_def def = def_of(3);
        duet_result result;
        duet_world *world = open_world(&def, 10);
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 7");
    }
}

TEST(bounds_with_lower_above_upper_are_named)
{
    for (uint32_t i = 0; i < 10; ++i)
        bounds[i] = (duet_bounds){{(float)i, 0, 0}, {(float)i + 1, 1, 1}};
    bounds[4].lower[1] = 2;
    duet_world_def def = def_of(3);
    def.shape = DUET_SHAPE_BOUNDS;
    duet_result result;
    duet_world *world = create_world_of(&def, DUET_OBJECT_BOUNDS, bounds, 10);
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 4");
}

// ------------------------------------------------------------ what must not count

static uint64_t hash_of(const duet_world_def *def, uint32_t n)
{
    duet_result result;
    duet_world *world = open_world(def, n);
    must(duet_world_step(world, &result, ERR));
    assert_true(result.pairs > 0);
    return duet_result_get_hash(&result);
}

// Coordinates are whole 1024ths, so that moving and mirroring are exact.
static void scatter_on_1024ths(uint32_t n, rng *r)
{
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = cube_at(rng_below(r, 10240) / 1024.0, rng_below(r, 10240) / 1024.0,
                           rng_below(r, 10240) / 1024.0, rng_below(r, 512) / 1024.0);
}

TEST(moving_and_mirroring_a_scene_changes_no_pair)
{
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    scatter_on_1024ths(2000, &r);
    uint64_t hash = hash_of(&def, 2000);
    const float moves[] = {-10, 0.125f, 1000, -0.3125f};
    for (size_t m = 0; m < sizeof moves / sizeof *moves; ++m) {
        for (uint32_t i = 0; i < 2000; ++i)
            for (int k = 0; k < 3; ++k)
                poses[i].centre[k] += moves[m];
        assert_int_equal(hash_of(&def, 2000), hash);
    }
    for (uint32_t i = 0; i < 2000; ++i)
        poses[i].centre[1] = -poses[i].centre[1];
    assert_int_equal(hash_of(&def, 2000), hash);
}

TEST(the_order_of_the_objects_changes_only_their_names)
{
    enum { N = 1500 };
    rng r = rng_seed(test_seed());
    duet_world_def def = def_of(3);
    scatter(N, &r, 0, 9, 0.5);
    duet_result result;
    duet_world *world = open_world(&def, N);
    must(duet_world_step(world, &result, ERR));
    // Object i takes the place N - 1 - i.
    uint64_t hash = 0;
    for (uint64_t i = 0; i < result.pairs; ++i) {
        duet_pair pair = duet_result_get_pair(&result, i);
        duet_pair renamed = {N - 1 - pair.b, N - 1 - pair.a};
        hash += duet_pairs_hash(&renamed, 1);
    }
    for (uint32_t i = 0; i < N / 2; ++i) {
        duet_pose other = poses[N - 1 - i];
        poses[N - 1 - i] = poses[i];
        poses[i] = other;
    }
    assert_int_equal(hash_of(&def, N), hash);
}

// ------------------------------------------------------------ bounds, and hard pairs

TEST(bounds_touch_and_miss_by_an_ulp)
{
    rng r = rng_seed(test_seed());
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_world_def def = def_of(dims);
        def.shape = DUET_SHAPE_BOUNDS;
        for (uint32_t i = 0; i < 1500; ++i)
            for (int k = 0; k < 3; ++k) {
                float lower = (float)rng_below(&r, 12);
                float upper = lower + (float)rng_below(&r, 2);
                bounds[i].lower[k] = rng_below(&r, 4) ? lower : nextafterf(lower, -1);
                bounds[i].upper[k] = rng_below(&r, 4) ? upper : nextafterf(upper, 100);
            }
        assert_true(agreement_check(&def, bounds, 1500) > 0);
    }
}

TEST(crowds_of_hard_pairs_are_decided_as_the_reference_does)
{
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (uint32_t dims = 2; dims <= 3; ++dims) {
            if (!test_takes((uint64_t)(c - hard_classes) + dims, 2))
                continue;
            for (uint32_t i = 0; i < 60; i += 2) {
                hard_pair pair = c->make(&r, dims);
                poses[i] = pair.a;
                poses[i + 1] = pair.b;
            }
            print_message("%s, %uD\n", c->name, dims);
            duet_world_def def = def_of(dims);
            assert_true(agreement_check(&def, poses, 60) > 0);
        }
}

// The devices' bounds are a little wider than the boxes, and a world may be just
// as long as its cells.
TEST(cells_that_fit_the_world_tightly_hold_their_objects)
{
    enum { N = 101, ROUNDS = 40 };
    duet_world_def def = def_of(2);
    double edge = sqrt(2.0) * (1.0 + 0x1p-16 + 100 * 0x1p-21);
    for (int round = 0; round < ROUNDS; ++round) {
        double step = edge * (1.0 + (round - 4) * 0x1p-21);
        for (int i = 0; i < N; ++i) {
            poses[i] = cube_at(i * step, 0, 0, 0.5);
            poses[i].rotation[2] = 0.38268343f; // 45 degrees
            poses[i].rotation[3] = 0.92387953f;
        }
        step_world(create_world_of(&def, DUET_OBJECT_POSES, poses, N));
    }
}
