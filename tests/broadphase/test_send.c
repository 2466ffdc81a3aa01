// SPDX-License-Identifier: MIT
// Devices with memory of their own are sent objects in chunks where that is asked
// for, and send pairs before they are asked, or count them. The CPU's parts here are told that they
// have such memory.
#include "support/devices.h"
#include "support/test.h"

#include "runtime/broadphase/world.h"

enum { CAPACITY = 5003 };

static duet_pose poses[CAPACITY];

static void begin(void)
{
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory = false;
}

// Unit cubes in a world of that edge.
static void fill(rng *r, uint32_t n, double edge)
{
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = random_cube(r, 0.0, edge);
    }
}

// One of the smallest chunks is what a group of the kernel takes.
static duet_world *make_world(duet_mode mode, const char *text, bool keep_bad)
{
    duet_world_def def = devices_def(3);
    def.plan.mode = mode;
    def.keep_bad = keep_bad;
    set_variants(&def.plan, text);
    duet_world *world = create_world(&def);
    world->parts[0].least_chunk = world->parts[1].least_chunk = 1;
    return world;
}

static duet_result step(duet_world *world, uint32_t n)
{
    return step_with(world, DUET_OBJECT_POSES, poses, n);
}

static void assert_step_is_the_reference(duet_world *world, uint32_t n)
{
    duet_result result = step(world, n);
    assert_found(&result, known_pairs_of(DUET_OBJECT_POSES, poses, n, 3));
}

// ------------------------------------------------------------ facts

TEST(objects_that_are_there_come_in_no_chunks)
{
    duet_result result;
    rng r = {test_seed()};
    duet_world *world = make_world(DUET_MODE_OWN, "gpu send=chunks", false);
    fill(&r, CAPACITY, 34.0);
    uint64_t pairs = step(world, CAPACITY).pairs;
    assert_true(world->parts[1].objects.n_chunks > 1);
    must(duet_world_step(world, &result, ERR));
    assert_int_equal(world->parts[1].objects.n_chunks, 0);
    assert_int_equal(result.pairs, pairs);
}

// The number of pairs is guessed from the step before, too high and too low, and
// lists and blocks on the host have to grow.
TEST(pairs_are_all_there_however_many_the_last_step_had)
{
    static const double edges[] = {34.0, 34.0, 12.0, 80.0, 12.0, 6.0, 6.0, 34.0};
    rng r = {test_seed()};
    duet_world *world = make_world(DUET_MODE_OWN, "gpu", false);
    for (size_t i = 0; i < sizeof edges / sizeof *edges; ++i) {
        fill(&r, 1000, edges[i]);
        set_share(world, i % 2 ? DUET_SHARE_ONE / 2 : 0);
        assert_step_is_the_reference(world, 1000);
    }
}

enum { SIDE = 10, TOUCHING = SIDE * SIDE * SIDE };

// Cubes that touch, all turned the same way: float cannot tell.
static void fill_touching(void)
{
    for (uint32_t i = 0; i < TOUCHING; ++i) {
        float x = (float)(i % SIDE), y = (float)(i / SIDE % SIDE), z = (float)(i / SIDE / SIDE);
        poses[i] = (duet_pose){{0.6f * x - 0.8f * y, 0.8f * x + 0.6f * y, z},
                               {0.5f, 0.5f, 0.5f},
                               {0.0f, 0.0f, 1.0f, 2.0f}};
    }
}

TEST(more_undecided_pairs_than_are_sent_ahead_are_decided)
{
    fill_touching();
    duet_world *world = make_world(DUET_MODE_OWN, "gpu", false);
    set_share(world, 0);
    assert_step_is_the_reference(world, TOUCHING);
    assert_step_is_the_reference(world, TOUCHING);
    duet_result result = step(world, TOUCHING);
    assert_true(result.undecided > 1024);
}

// ------------------------------------------------------------ pairs that are counted

// Objects with ids of 64 bits, and those that have none.
static uint64_t names[CAPACITY];
static uint32_t without[CAPACITY], changed[CAPACITY];

static bool has_name(const global_ids *ids, uint32_t place)
{
    bool has = place < ids->n && names[place] != UINT64_MAX;
    for (uint32_t i = 0; i < ids->n_without; ++i)
        has &= without[i] != place;
    return has;
}

// Number and hash of pairs, by the ids that a function of them gives.
typedef struct sums {
    uint64_t n, hash;
} sums;

static uint64_t mixed(uint64_t key)
{
    const duet_pair words = {(uint32_t)(key >> 32), (uint32_t)key};
    return duet_pairs_hash(&words, 1);
}

// Hashes as duet_cluster.h says.
static void add_named(sums *to, duet_pair pair)
{
    uint64_t a = names[pair.a], b = names[pair.b];
    uint64_t least = a < b ? a : b, most = a < b ? b : a;
    ++to->n;
    to->hash += mixed((least << 32 | (uint32_t)most) ^ mixed(least >> 32 << 32 | most >> 32));
}

static void add_pair(sums *named, sums *left, const global_ids *ids, duet_pair pair)
{
    if (has_name(ids, pair.a) && has_name(ids, pair.b)) {
        add_named(named, pair);
    } else if (pair.a < ids->n || pair.b < ids->n) {
        ++left->n;
        left->hash += duet_pairs_hash(&pair, 1);
    }
}

// A step of n objects counts what the reference finds, leaves the rest, and brings all when asked.
static duet_result count_step(duet_world *world, const global_ids *ids, uint32_t n)
{
    duet_result result;
    part_counted counted[2];
    sums expected_named = {0}, expected_left = {0}, named = {0}, left = {0};
    duet_pair *pairs = NULL;
    uint64_t n_pairs = 0;
    duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, poses, n, 3, 0, ERR));
    must(duet_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, &n_pairs, ERR));
    for (uint64_t i = 0; i < n_pairs; ++i)
        add_pair(&expected_named, &expected_left, ids, pairs[i]);
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, ERR));
    must(world_step_counting(world, ids, &result, counted, ERR));
    for (int side = 0; side < 2; ++side) {
        named.n += counted[side].n;
        named.hash += counted[side].hash;
        for (uint64_t i = 0; i < result.spans[side].n; ++i)
            add_pair(&named, &left, ids, result.spans[side].pairs[i]);
    }
    assert_int_equal(named.n, expected_named.n);
    assert_int_equal(named.hash, expected_named.hash);
    assert_int_equal(left.n, expected_left.n);
    assert_int_equal(left.hash, expected_left.hash);
    assert_true(result.pairs <= left.n + result.undecided);
    must(world_read_counted(world, result.spans, ERR));
    assert_int_equal(result.spans[0].n + result.spans[1].n, n_pairs);
    assert_int_equal(duet_result_get_hash(&result), duet_pairs_hash(pairs, n_pairs));
    duet_free(pairs);
    return result;
}

// Some ids change, and some objects have none from now on.
static void change_ids(global_ids *ids, rng *r)
{
    ids->n_changed = 0;
    for (uint32_t i = 0; i < ids->n_without; ++i) // they have one again
        changed[ids->n_changed++] = without[i];
    for (int i = 0; i < 10; ++i) {
        uint32_t place = rng_below(r, ids->n);
        names[place] ^= UINT64_C(1) << 50;
        for (int twice = 0; twice < 2; ++twice)
            changed[ids->n_changed++] = place;
    }
    ids->n_without = 0;
    for (uint32_t i = rng_below(r, 99); i < ids->n; i += 1 + rng_below(r, 99)) {
        without[ids->n_without++] = i;
        changed[ids->n_changed++] = i;
    }
}

static duet_world *make_counting_world(void)
{
    duet_world *world = make_world(DUET_MODE_OWN, "gpu", false);
    duet_plan plan = *duet_world_get_plan(world);
    strcpy(plan.variant_b, "gpu count_pairs.WG=64 count_pairs.PER_ITEM=8");
    must(duet_world_set_plan(world, &plan, ERR));
    return world;
}

// Any part of the objects has ids, below 2^32 and far above, and ids change or a device missed
// those that did.
TEST(pairs_of_objects_with_ids_are_counted_where_they_are_found)
{
    enum { N = 3000, ROUNDS = 12 };
    static const uint32_t homes[ROUNDS] = {2900, 2900, 2900, 1500, 1500, 60,
                                           2999, 3000, 3000, 0,    2000, 2950};
    static const double edges[ROUNDS] = {28, 28, 28, 9, 9, 28, 28, 60, 28, 28, 28, 28};
    rng r = {test_seed()};
    duet_world *world = make_counting_world();
    for (uint32_t i = 0; i < N; ++i) {
        uint32_t k = (i * 7919) % N;
        names[i] = i == 77      ? UINT64_MAX
                   : k % 4 == 0 ? k
                   : k % 4 == 1 ? UINT64_C(5) << 32 | k
                                : UINT64_MAX - 1 - k;
    }
    global_ids ids = {.list = names, .without = without, .changed = changed};
    for (int at = 0; at < ROUNDS; ++at) {
        bool more = homes[at] > ids.n;
        ids.n = homes[at];
        fill(&r, N, edges[at]);
        if (at % 3 != 2 && ids.n > 0)
            change_ids(&ids, &r);
        else
            ids.n_changed = 0;
        if (at == 0 || more)
            ids.n_changed = ALL_IDS_CHANGED;
        set_share(world, at % 5 == 3 ? DUET_SHARE_ONE : at % 5 == 4 ? 0 : DUET_SHARE_ONE / 2);
        for (uint32_t i = 0; i < ids.n_without; ++i)
            if (without[i] >= ids.n)
                ids.n_without = i;
        count_step(world, &ids, N);
    }
}

// Pairs that the host decides are not counted.
TEST(undecided_pairs_are_counted_once)
{
    duet_world *world = make_counting_world();
    fill_touching();
    for (uint32_t i = 0; i < TOUCHING; ++i)
        names[i] = i;
    global_ids ids = {.list = names, .n = TOUCHING - 10, .n_changed = ALL_IDS_CHANGED};
    set_share(world, 0);
    for (int at = 0; at < 2; ++at)
        assert_true(count_step(world, &ids, TOUCHING).undecided > 1024);
}

TEST(a_bad_object_of_any_chunk_is_named)
{
    rng r = {test_seed()};
    duet_world *world = make_world(DUET_MODE_SLAB, "gpu send=chunks", true);
    fill(&r, CAPACITY, 34.0);
    poses[4321].half_extents[2] = -1.0f;
    poses[1500].centre[2] = NAN;
    poses[CAPACITY - 1].rotation[0] = INFINITY;
    set_share(world, DUET_SHARE_ONE / 2);
    duet_result result = step(world, CAPACITY);
    assert_int_equal(result.bad, 3);
    assert_int_equal(result.first_bad, 1500);
}

static double all_ms(const duet_result *result)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < result->n_stages; ++i)
        sum += result->stages[i].ms;
    return sum;
}

// Which steps have times of their own is known; the others show the last ones.
TEST(stages_have_times_where_they_are_asked_for)
{
    rng r = {test_seed()};
    duet_world *world = make_world(DUET_MODE_SLAB, "gpu send=chunks", false);
    fill(&r, CAPACITY, 34.0);
    set_share(world, DUET_SHARE_ONE / 2);
    uint64_t hash = 0;
    double last_ms = 0.0, last_kernel_ms = 0.0;
    int fresh = 0;
    for (int k = 0; k < 40; ++k) {
        world->def.stage_times = k > 34;
        duet_result result = step(world, CAPACITY);
        assert_true(result.timed == (k % 16 == 0 || k > 34));
        assert_true(result.n_stages > 0);
        assert_true(result.kernel_ms[0] > 0.0 && result.kernel_ms[1] > 0.0);
        if (result.timed)
            fresh += all_ms(&result) != last_ms;
        else
            assert_true(all_ms(&result) == last_ms && result.kernel_ms[1] == last_kernel_ms);
        last_ms = all_ms(&result);
        last_kernel_ms = result.kernel_ms[1];
        hash = hash ? hash : duet_result_get_hash(&result);
        assert_int_equal(duet_result_get_hash(&result), hash);
    }
    assert_true(fresh > 5); // out of eight; two sums of times may be equal by chance
}

TEST_BEGIN(begin)
