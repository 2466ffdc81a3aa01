// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "support/devices.h"

#include "runtime/scene/reference.h"

enum { N = 600 };

typedef struct crowd {
    reference_objects objects;
    duet_pose poses[N];
    duet_bounds bounds[N];
} crowd;

static duet_pose scattered(rng *r, double world, double half)
{
    duet_pose pose = cube_at(rng_between(r, -world, world), rng_between(r, -world, world),
                             rng_between(r, -world, world), half);
    pose.half_extents[1] *= (float)rng_unit(r);
    turn_at_random(&pose, r);
    return pose;
}

static duet_pose even(rng *r, uint32_t i)
{
    (void)i;
    return scattered(r, 4, 0.5);
}

static duet_pose of_mixed_size(rng *r, uint32_t i)
{
    (void)i;
    return scattered(r, 5, pow(10, rng_between(r, -4, 0.5)));
}

static duet_pose clustered(rng *r, uint32_t i)
{
    duet_pose pose = scattered(r, 0.5, 0.1);
    pose.centre[0] += 1e6f * (float)(i % 5);
    return pose;
}

static duet_pose on_a_lattice(rng *r, uint32_t i)
{
    (void)r;
    return cube_at(i % 8, i / 8 % 8, i / 64, 0.5);
}

static duet_pose in_one_place(rng *r, uint32_t i)
{
    (void)i;
    return scattered(r, 0, 0.5);
}

static duet_pose a_point_or_a_giant(rng *r, uint32_t i)
{
    return i % 100 == 0 ? scattered(r, 10, 1e6) : scattered(r, 1, i % 3 ? 0 : 0.2);
}

static duet_pose at_the_ends_of_float(rng *r, uint32_t i)
{
    return i % 2 ? scattered(r, 1e38, 3e37) : scattered(r, 1e-38, 1e-39);
}

typedef duet_pose (*maker)(rng *r, uint32_t i);

static const maker makers[] = {
    even,
    of_mixed_size,
    clustered,
    on_a_lattice,
    in_one_place,
    a_point_or_a_giant,
    at_the_ends_of_float,
};

static crowd *make_crowd(maker make, uint32_t dims, duet_shape shape, rng *r)
{
    crowd *c = test_alloc(sizeof *c);
    c->objects = (reference_objects){
        .dims = dims, .shape = shape, .n = N, .poses = c->poses, .bounds = c->bounds};
    for (uint32_t i = 0; i < N; ++i) {
        c->poses[i] = make(r, i);
        c->bounds[i] = bounds_of_upright(&c->poses[i]);
    }
    return c;
}

static void assert_same(const reference_found *a, const reference_found *b)
{
    assert_int_equal(a->candidates, b->candidates);
    assert_int_equal(a->n, b->n);
    if (a->n > 0)
        assert_memory_equal(a->pairs, b->pairs, a->n * sizeof *a->pairs);
}

TEST(columns_find_what_each_with_each_finds)
{
    rng r = rng_seed(test_seed());
    for (size_t i = 0; i < 4 * sizeof makers / sizeof *makers; ++i) {
        duet_shape shape = i % 2 ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES;
        crowd *c = make_crowd(makers[i / 4], 2 + (uint32_t)i / 2 % 2, shape, &r);
        const reference_found each = found_by(&c->objects, REFERENCE_EACH_WITH_EACH),
                              columns = found_by(&c->objects, REFERENCE_COLUMNS);
        assert_true(each.n > 0);
        assert_same(&each, &columns);
    }
}

TEST(each_level_has_its_set_however_it_is_found)
{
    rng r = rng_seed(test_seed());
    for (int l = 0; l < DUET_LEVELS; ++l) {
        crowd *c = make_crowd(of_mixed_size, 3, DUET_SHAPE_POSES, &r);
        c->objects.level = (duet_level)l;
        c->objects.rotated = true;
        const reference_found each = found_by(&c->objects, REFERENCE_EACH_WITH_EACH),
                              columns = found_by(&c->objects, REFERENCE_COLUMNS);
        c->objects.level = DUET_LEVEL_CERTIFIED;
        const reference_found exact = found_by(&c->objects, REFERENCE_COLUMNS);
        assert_same(&each, &columns);
        assert_true(l == DUET_LEVEL_AABB ? each.n == each.candidates : each.n >= exact.n);
    }
}

TEST(pairs_ascend)
{
    rng r = rng_seed(test_seed());
    crowd *c = make_crowd(of_mixed_size, 3, DUET_SHAPE_POSES, &r);
    const reference_found found = found_by(&c->objects, REFERENCE_COLUMNS);
    for (uint64_t i = 0; i < found.n; ++i) {
        assert_true(found.pairs[i].a < found.pairs[i].b);
        if (i > 0)
            assert_true(found.pairs[i - 1].a < found.pairs[i].a ||
                        (found.pairs[i - 1].a == found.pairs[i].a &&
                         found.pairs[i - 1].b < found.pairs[i].b));
    }
}

// 8 x 8 x 8 cubes that touch along faces, edges and corners.
TEST(all_neighbours_on_a_lattice_touch)
{
    rng r = rng_seed(1);
    crowd *c = make_crowd(on_a_lattice, 3, DUET_SHAPE_POSES, &r);
    c->objects.n = 512;
    const reference_found found = found_by(&c->objects, REFERENCE_COLUMNS);
    uint64_t met = 22 * 22 * 22; // (2 * 7 + 8)^3 ordered pairs, each cube with itself among them
    assert_int_equal(found.n, (met - 512) / 2);
}

TEST(none_one_and_two_objects_are_scenes_too)
{
    duet_pose two[] = {cube_at(0, 0, 0, 0.5), cube_at(1, 1, 1, 0.5)};
    for (uint32_t n = 0; n <= 2; ++n)
        for (int way = REFERENCE_EACH_WITH_EACH; way <= REFERENCE_COLUMNS; ++way) {
            reference_objects objects = {.dims = 3, .n = n, .poses = two};
            const reference_found found = found_by(&objects, (reference_way)way);
            assert_int_equal(found.n, n == 2);
        }
}

TEST(a_scene_gives_the_pairs_of_its_objects)
{
    rng r = rng_seed(test_seed());
    crowd *c = make_crowd(even, 3, DUET_SHAPE_POSES, &r);
    duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, c->poses, N, 3, 0, ERR));
    const reference_found found = found_by(&c->objects, REFERENCE_COLUMNS);
    duet_pair *pairs;
    uint64_t n;
    must(duet_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, &n, ERR));
    assert_int_equal(n, found.n);
    assert_memory_equal(pairs, found.pairs, n * sizeof *pairs);
    duet_free(pairs);
}
