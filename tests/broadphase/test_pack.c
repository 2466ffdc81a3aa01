// SPDX-License-Identifier: MIT
// Devices with memory of their own are sent only the objects of their slabs.
// The CPU's parts here are told that they have such memory.
#include "support/test.h"

#include "support/devices.h"

#include "runtime/broadphase/world.h"

enum { CAPACITY = 6000 };

static duet_pose poses[CAPACITY];

// ------------------------------------------------------------ scenes

// Unit cubes, about as dense as in the paper.
static double edge_of(uint32_t n, uint32_t dims)
{
    return dims == 3 ? 2.0 * cbrt(n) : 2.0 * sqrt(n);
}

static void fill_poses(rng *r, uint32_t n, uint32_t dims)
{
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = random_cube(r, 0.0, edge_of(n, dims));
}

static known_pairs poses_pairs(uint32_t n, uint32_t dims)
{
    return known_pairs_of(DUET_OBJECT_POSES, poses, n, dims);
}

// ------------------------------------------------------------ worlds

static const uint32_t shares[] = {0, 1, DUET_SHARE_ONE * 3 / 10, DUET_SHARE_ONE / 2,
                                  DUET_SHARE_ONE};
enum { SHARES = sizeof shares / sizeof *shares };

// Packs in more chunks than there are slots.
static duet_world *make_world(const duet_world_def *def)
{
    duet_world *world = create_world(def);
    world->lists.least_chunk = 64;
    return world;
}

static duet_world_def world_def(uint32_t dims, const char *text)
{
    duet_world_def def = devices_def(dims);
    def.stage_times = true;
    def.plan = plan_of(DUET_MODE_SLAB, DUET_SHARE_ONE / 2, text, text);
    return def;
}

static void set_memory(bool host_a, bool host_b)
{
    default_pair()->devices[0].info.host_memory = host_a;
    default_pair()->devices[1].info.host_memory = host_b;
}

// A world that is sent packed objects, which lie there, by devices with memory of their own.
static duet_world *packed_world(rng *r, uint32_t n)
{
    set_memory(false, false);
    fill_poses(r, n, 3);
    duet_world_def def = world_def(3, "gpu send=packed");
    return make_world(&def);
}

static duet_result step_poses(duet_world *world, uint32_t n)
{
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, ERR));
    return step_world(world);
}

static void assert_poses_are_found(duet_world *world, uint32_t n, known_pairs truth)
{
    const duet_result result = step_poses(world, n);
    assert_found(&result, truth);
}

static double stage_ms(const duet_result *result, const char *name, int side)
{
    for (uint32_t i = 0; i < result->n_stages; ++i)
        if (strcmp(result->stages[i].name, name) == 0 && result->stages[i].device == side)
            return result->stages[i].ms;
    return -1.0;
}

static bool was_packed(const duet_result *result, int side)
{
    return stage_ms(result, "pack", side) >= 0.0;
}

// ------------------------------------------------------------ facts

TEST(any_share_and_number_gives_the_reference_pairs)
{
    static const uint32_t numbers[] = {1, 2, 3, 7, 13, 997, 5003};
    rng r = {test_seed()};
    set_memory(false, false);
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_world_def def = world_def(dims, "gpu send=packed");
        duet_world *world = make_world(&def);
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
            fill_poses(&r, numbers[i], dims);
            const known_pairs truth = poses_pairs(numbers[i], dims);
            for (int s = 0; s < SHARES; ++s) {
                set_share(world, shares[s]);
                assert_poses_are_found(world, numbers[i], truth);
            }
        }
    }
}

TEST(every_sort_takes_packed_objects)
{
    static const char *const variants[] = {
        "gpu send=packed sort=radix", "gpu send=packed FROM_IDS=0", "gpu send=packed FROM_IDS=1",
        "gpu send=packed hash.LANES=1 hash.WG=64 hash.PER_ITEM=1", "gpu send=all"};
    enum { N = 2003 };
    rng r = {test_seed()};
    set_memory(false, false);
    fill_poses(&r, N, 3);
    const known_pairs truth = poses_pairs(N, 3);
    for (size_t v = 0; v < sizeof variants / sizeof *variants; ++v) {
        duet_world_def def = world_def(3, variants[v]);
        duet_world *world = make_world(&def);
        const duet_result result = step_poses(world, N);
        assert_found(&result, truth);
        assert_int_equal(was_packed(&result, 0), strcmp(variants[v], "gpu send=all") != 0);
    }
}

TEST(each_device_is_sent_its_slab_alone)
{
    enum { N = 5003 };
    rng r = {test_seed()};
    duet_world *world = packed_world(&r, N);
    duet_result result = step_poses(world, N);
    assert_true(was_packed(&result, 0) && was_packed(&result, 1));
    const device_view *a = &world->parts[0].objects;
    const device_view *b = &world->parts[1].objects;
    assert_in_range(a->n, N / 3, N * 2 / 3);
    assert_in_range(b->n, N / 3, N * 2 / 3);
    assert_in_range(a->n + b->n, N, N * 6 / 5); // A has ghosts, too
}

TEST(objects_that_move_between_steps_are_found)
{
    enum { N = 3001, STEPS = 12 };
    rng r = {test_seed()};
    duet_world *world = packed_world(&r, N);
    for (int k = 0; k < STEPS; ++k) {
        assert_poses_are_found(world, N, poses_pairs(N, 3));
        // all drift into one slab, out of its space, and beyond the world
        for (uint32_t i = 0; i < N; ++i)
            poses[i].centre[2] += k < STEPS / 2 ? -6.0f : 9.0f;
    }
}

TEST(objects_outside_the_world_are_found)
{
    enum { N = 2003 };
    rng r = {test_seed()};
    set_memory(false, false);
    for (uint32_t i = 0; i < N; ++i)
        poses[i] = random_cube(&r, -12.0, 24.0);
    duet_world_def def = world_def(3, "gpu send=packed");
    def.has_world = true;
    for (int k = 0; k < 3; ++k)
        def.upper[k] = 16.0f;
    duet_world *world = make_world(&def);
    const known_pairs truth = poses_pairs(N, 3);
    for (int s = 0; s < SHARES; ++s) {
        set_share(world, shares[s]);
        assert_poses_are_found(world, N, truth);
    }
}

TEST(objects_that_stay_are_neither_packed_nor_sent_again)
{
    enum { N = 2003 };
    rng r = {test_seed()};
    duet_world *world = packed_world(&r, N);
    duet_result first = step_poses(world, N);
    const known_pairs truth = {first.pairs, duet_result_get_hash(&first)};
    duet_result again = step_world(world);
    assert_false(was_packed(&again, 0) || was_packed(&again, 1));
    assert_true(stage_ms(&again, "send objects", 0) < 0.0);
    assert_found(&again, truth);
    set_share(world, DUET_SHARE_ONE); // all to A, then slabs once more
    assert_step_finds(world, truth);
    set_share(world, DUET_SHARE_ONE / 2);
    duet_result cut = step_world(world);
    assert_true(was_packed(&cut, 0));
    assert_found(&cut, truth);
}

// Every number of a pose may be the bad one, and its row a ghost row.
static uint32_t spoil(rng *r, uint32_t n)
{
    enum { BAD = 40 };
    for (uint32_t i = 0; i < BAD; ++i) {
        float *numbers = (float *)&poses[n - 1 - i * (n / BAD)];
        numbers[rng_below(r, 10)] = rng_below(r, 2) ? NAN : INFINITY;
    }
    return BAD;
}

// However the objects come: each device packed or given all of them.
TEST(bad_objects_are_counted_once_and_the_first_is_named)
{
    enum { N = 2003 };
    static const struct {
        const char *variant;
        bool host_a, host_b;
    } ways[] = {
        {"gpu send=packed", false, false},
        {"gpu send=packed", true, false},
        {"gpu", false, false},
        {"simd", true, true},
    };
    rng r = {test_seed()};
    fill_poses(&r, N, 3);
    uint32_t n_bad = spoil(&r, N);
    uint32_t first = N - 1 - (n_bad - 1) * (N / n_bad);
    known_pairs truth = {0};
    for (size_t w = 0; w < sizeof ways / sizeof *ways; ++w) {
        set_memory(ways[w].host_a, ways[w].host_b);
        duet_world_def def = world_def(3, ways[w].variant);
        def.keep_bad = true;
        duet_world *world = make_world(&def);
        for (int s = 0; s < SHARES; ++s) {
            set_share(world, shares[s]);
            duet_result result = step_poses(world, N);
            assert_int_equal(result.bad, n_bad);
            assert_int_equal(result.first_bad, first);
            if (w == 0 && s == 0)
                truth = (known_pairs){result.pairs, duet_result_get_hash(&result)};
            assert_found(&result, truth);
        }
    }
}

TEST(a_bad_object_that_is_packed_is_refused_by_its_id)
{
    enum { N = 2003 };
    duet_result result;
    rng r = {test_seed()};
    duet_world *world = packed_world(&r, N);
    poses[1234].half_extents[1] = -1.0f;
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 1234 of 2003");
}

TEST(a_device_without_room_fails_the_step_and_not_the_next)
{
    enum { N = 5003 };
    duet_result result;
    rng r = {test_seed()};
    set_memory(false, false);
    fill_poses(&r, N, 3);
    for (int side = 0; side < 2; ++side) {
        duet_world_def def = world_def(3, "auto");
        duet_world *world = make_world(&def);
        uint64_t *most = &default_pair()->devices[side].info.max_buffer_bytes;
        uint64_t before = *most;
        must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
        *most = 8192;
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_NO_MEMORY, "");
        *most = before;
        assert_step_finds(world, poses_pairs(N, 3));
    }
}
