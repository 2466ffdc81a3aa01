// SPDX-License-Identifier: MIT
// Objects may lie in host memory, in a buffer on devices, or be there from the step before; a
// device may be sent all of them, ranges, a list of its slab, or the first ones before the step.
// Any such way, in any order, gives the reference's pairs, and rows that lie there are not sent
// again.
#include "support/test.h"

#include "support/devices.h"

#include "runtime/broadphase/world.h"

enum { SETS = 4, MOST = 4000, ROUNDS = 100 };

// Objects, and the hash of their pairs.
static struct {
    duet_pose poses[MOST];
    duet_bounds bounds[MOST];
    uint32_t n;
    uint64_t hashes[2]; // hashes of poses, of bounds
} sets[SETS];

// Unit cubes; those of every second set lie in about the order of z, which is that of cells.
static void fill_set(rng *r, int s, uint32_t n)
{
    const double edge = 2.0 * cbrt(n);
    sets[s].n = n;
    for (uint32_t i = 0; i < n; ++i) {
        duet_pose *pose = &sets[s].poses[i];
        *pose = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}};
        for (int k = 0; k < 3; ++k)
            pose->centre[k] = (float)rng_between(r, 0.0, edge);
        if (s % 2 == 0 && rng_below(r, 100) > 0)
            pose->centre[2] = (float)(edge * i / n);
        turn_at_random(pose, r);
        for (int k = 0; k < 3; ++k) {
            sets[s].bounds[i].lower[k] = pose->centre[k];
            sets[s].bounds[i].upper[k] = pose->centre[k] + 1.0f;
        }
    }
    sets[s].hashes[0] = known_pairs_of(DUET_OBJECT_POSES, sets[s].poses, n, 3).hash;
    sets[s].hashes[1] = known_pairs_of(DUET_OBJECT_BOUNDS, sets[s].bounds, n, 3).hash;
}

static const void *rows_of(const duet_world *world, int s)
{
    return world->objects.kind == DUET_OBJECT_POSES ? (const void *)sets[s].poses : sets[s].bounds;
}

// ------------------------------------------------------------ ways

static void set_copy(duet_world *world, rng *r, int s)
{
    (void)r;
    must(duet_world_set_objects(world, world->objects.kind, rows_of(world, s), sets[s].n, ERR));
}

static uint32_t n_prefetched, n_listed, n_in_ranges;

// The first objects are sent while the others are written, unless that is stopped.
static void prefetch(duet_world *world, rng *r, int s)
{
    const size_t row = world_kind_bytes(world->objects.kind);
    const uint32_t n = sets[s].n, first = 1 + rng_below(r, n);
    must(duet_world_map_objects(world, world->objects.kind, n, ERR));
    char *to = must(duet_world_map_objects(world, world->objects.kind, first, ERR));
    memcpy(to, rows_of(world, s), first * row);
    world_prefetch(world, first);
    for (int side = 0; side < 2; ++side)
        n_prefetched += view_is_prefetched(&world->parts[side].objects) &&
                        world->parts[side].objects.generation == world->objects.all.generation;
    if (rng_below(r, 4) == 0)
        world_cancel_prefetch(world);
    assert_null(world_extend_objects(world, world->objects.kind, 3 * MOST));
    assert_ptr_equal(world_extend_objects(world, world->objects.kind, n), to);
    memcpy(to + first * row, (const char *)rows_of(world, s) + first * row, (n - first) * row);
}

// Devices of one context both have it.
static void put_in_buffer(duet_world *world, rng *r, int s)
{
    cl_int code = CL_SUCCESS;
    const size_t bytes = sets[s].n * world_kind_bytes(world->objects.kind);
    cl_mem mem = clCreateBuffer(default_pair()->devices[rng_below(r, 2)].context,
                                CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes,
                                (void *)(uintptr_t)rows_of(world, s), &code);
    assert_int_equal(code, CL_SUCCESS);
    must(duet_world_set_objects_buffer(world, world->objects.kind, mem, sets[s].n, 0, NULL, ERR));
    clReleaseMemObject(mem);
}

typedef void bringing(duet_world *world, rng *r, int s);

static const struct {
    const char *name;
    bringing *bring;
} ways[] = {{"copied", set_copy}, {"prefetched", prefetch}, {"in a buffer", put_in_buffer}};

enum { WAYS = sizeof ways / sizeof *ways };

static const struct {
    duet_mode mode;
    const char *variants[2];
} plans[] = {
    {DUET_MODE_OWN, {"gpu", "simd"}},
    {DUET_MODE_OWN, {"gpu send=chunks", "gpu send=chunks"}},
    {DUET_MODE_SHARED, {"gpu send=chunks", "gpu"}},
    {DUET_MODE_SHARED, {"paper", "paper"}},
    {DUET_MODE_SLAB, {"gpu send=packed", "gpu send=packed"}},
    {DUET_MODE_SLAB, {"gpu sort=radix", "gpu send=packed sort=radix"}},
    {DUET_MODE_SLAB, {"simd", "gpu send=chunks"}},
};

enum { PLANS = sizeof plans / sizeof *plans };

// ------------------------------------------------------------ worlds

static duet_world *make_world(duet_shape shape, bool ordered)
{
    duet_world_def def = devices_def(3);
    def.shape = shape;
    def.rotated = shape == DUET_SHAPE_POSES;
    def.ordered = ordered;
    def.stage_times = true;
    duet_world *world = create_world(&def);
    world->parts[0].least_chunk = world->parts[1].least_chunk = 1;
    world->lists.least_chunk = 64;
    return world;
}

static void set_plan(duet_world *world, rng *r, uint32_t p)
{
    static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE / 2, DUET_SHARE_ONE};
    duet_plan plan =
        plan_of(plans[p].mode, shares[rng_below(r, 4)], plans[p].variants[0], plans[p].variants[1]);
    must(duet_world_set_plan(world, &plan, ERR));
}

static duet_result step(duet_world *world, int s, const char *way, uint32_t p)
{
    duet_result result = step_world(world);
    if (duet_result_get_hash(&result) != sets[s].hashes[world->objects.kind != DUET_OBJECT_POSES])
        fail_msg("objects %s, plan %u ('%s', '%s'), share %u, %s: %llu pairs are not the "
                 "reference's",
                 way, p, plans[p].variants[0], plans[p].variants[1], world->def.plan.share,
                 world->def.ordered ? "ordered" : "in no order", (unsigned long long)result.pairs);
    for (int side = 0; side < 2; ++side) {
        n_listed += world->parts[side].objects.there.kind == SELECT_LIST;
        n_in_ranges += world->parts[side].objects.there.kind == SELECT_RANGES;
    }
    return result;
}

static bool sends(const duet_result *result)
{
    bool sends = false;
    for (uint32_t i = 0; i < result->n_stages; ++i)
        sends |= strcmp(result->stages[i].name, "send objects") == 0 && result->stages[i].ms > 0.0;
    return sends;
}

// ------------------------------------------------------------ facts

// Each round brings other objects or keeps them, takes another plan or keeps it, and steps; a
// second step of the same sends nothing.
static void try_in_any_order(rng *r, duet_shape shape, bool ordered)
{
    duet_world *world = make_world(shape, ordered);
    const bool copies = !default_pair()->devices[0].info.host_memory;
    uint32_t p = 0;
    int s = 0;
    set_copy(world, r, s);
    set_plan(world, r, p);
    for (int round = 0; round < ROUNDS; ++round) {
        uint32_t w = rng_below(r, WAYS + 1);
        if (w < WAYS)
            ways[w].bring(world, r, s = (int)rng_below(r, SETS));
        if (rng_below(r, 3) == 0)
            set_plan(world, r, p = (p + 1 + rng_below(r, 2)) % PLANS);
        const char *way = w < WAYS ? ways[w].name : "that were there";
        step(world, s, way, p);
        if (rng_below(r, 3) == 0) {
            duet_result again = step(world, s, way, p);
            assert_false(copies && sends(&again));
        }
    }
}

TEST(any_way_and_order_gives_the_reference_pairs)
{
    static const uint32_t numbers[SETS] = {MOST, 2500, 1025, 1};
    rng r = {test_seed()};
    for (int s = 0; s < SETS; ++s)
        fill_set(&r, s, numbers[s]);
    for (int memory = 0; memory < 4; ++memory) {
        for (int side = 0; side < 2; ++side)
            default_pair()->devices[side].info.host_memory = memory >> side & 1;
        try_in_any_order(&r, DUET_SHAPE_POSES, memory % 2);
        try_in_any_order(&r, DUET_SHAPE_POSES, memory < 2);
        try_in_any_order(&r, DUET_SHAPE_BOUNDS, memory >= 2);
    }
    assert_true(n_prefetched > 10 && n_listed > 10 && n_in_ranges > 10);
}
