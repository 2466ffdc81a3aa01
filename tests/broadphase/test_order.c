// SPDX-License-Identifier: MIT
// The order by cell, and worlds whose objects are kept in about that order.
#include "support/test.h"

#include "support/devices.h"

#include "runtime/broadphase/order.h"
#include "runtime/selection/profile_subject.h"

// So many are ordered by several threads.
enum { CAPACITY = 20000, MANY = 65537 };

static duet_pose poses[MANY];

// ------------------------------------------------------------ scenes

// Unit cubes, about as dense as in the paper.
static void fill_poses(rng *r, uint32_t n, uint32_t dims)
{
    double edge = dims == 3 ? 2.0 * cbrt(n) : 2.0 * sqrt(n);
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = random_cube(r, 0, edge);
}

static void set_large_poses(duet_world *world, uint32_t n)
{
    static duet_large_pose large[CAPACITY];
    for (uint32_t i = 0; i < n; ++i) {
        const float *at = poses[i].centre;
        const double centre[3] = {at[0], at[1], at[2]};
        large[i] = (duet_large_pose){.pose = poses[i]};
        must(duet_large_pose_set(&large[i], centre, world->def.origin_edge, ERR));
    }
    must(duet_world_set_objects(world, DUET_OBJECT_LARGE_POSES, large, n, ERR));
}

static void set_poses(duet_world *world, uint32_t n)
{
    if (world->def.origin_edge > 0.0f) {
        set_large_poses(world, n);
        return;
    }
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, ERR));
}

static uint32_t *order_of(duet_world *world, uint32_t n)
{
    uint32_t *order = NULL, n_ordered = 0;
    must(duet_world_order(world, &order, &n_ordered, ERR));
    assert_int_equal(n_ordered, n);
    return order;
}

// ------------------------------------------------------------ the order

static void assert_is_permutation(const uint32_t *order, uint32_t n)
{
    uint8_t *seen = test_alloc(n + 1);
    for (uint32_t i = 0; i < n; ++i) {
        assert_in_range(order[i], 0, n - 1);
        assert_false(seen[order[i]]);
        seen[order[i]] = 1;
    }
}

static double number_of_cells(const duet_world *world)
{
    const cl_int *cells = world->grid.levels[0].cells.s;
    return (double)cells[0] * cells[1] * cells[2];
}

// Two of more cells than there are keys are one along each axis, or four.
static uint64_t key_of(const duet_world *world, uint32_t id)
{
    const grid_objects objects = world->objects;
    const cl_int *cells = world->grid.levels[0].cells.s;
    uint64_t along[3] = {(uint64_t)cells[0], (uint64_t)cells[1], (uint64_t)cells[2]};
    uint32_t cell[3];
    grid_cell_of(cell, &world->grid, &objects, id);
    while ((double)along[0] * (double)along[1] * (double)along[2] > 0x1p63)
        for (int k = 0; k < 3; ++k) {
            along[k] = (along[k] + 1) / 2;
            cell[k] /= 2;
        }
    return (cell[2] * along[1] + cell[1]) * along[0] + cell[0];
}

// The grid, too, is fitted by them.
static void assert_any_threads_give(const uint32_t *order, duet_world *world, uint32_t n)
{
    static const uint32_t n_threads[] = {1, 2, 3, 5, 1000};
    const grid fitted = world->grid;
    uint32_t *again = test_alloc(n * sizeof *again + 1);
    void *scratch = test_alloc((size_t)n * ORDER_SCRATCH + 1);
    for (size_t i = 0; i < sizeof n_threads / sizeof *n_threads; ++i) {
        world_forget_grid(world);
        memset(again, 0xff, n * sizeof *again);
        must(world_order(world, n_threads[i], again, scratch, ERR));
        assert_memory_equal(again, order, n * sizeof *again);
        if (n > 0)
            assert_memory_equal(world->grid.levels, fitted.levels, sizeof fitted.levels);
    }
}

static void assert_is_by_cell(duet_world *world, uint32_t n)
{
    uint32_t *order = order_of(world, n);
    assert_is_permutation(order, n);
    for (uint32_t i = 1; i < n; ++i) {
        uint64_t before = key_of(world, order[i - 1]), key = key_of(world, order[i]);
        assert_true(before < key || (before == key && order[i - 1] < order[i]));
    }
    assert_any_threads_give(order, world, n);
    duet_free(order);
}

TEST(the_order_is_a_permutation_by_cell_then_id)
{
    static const uint32_t numbers[] = {0, 1, 2, 5, 997, 6000, (1 << 15) - 1, 1 << 15, MANY};
    rng r = {test_seed()};
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
            duet_world_def def = devices_def(dims);
            duet_world *world = create_world(&def);
            fill_poses(&r, numbers[i], dims);
            set_poses(world, numbers[i]);
            assert_is_by_cell(world, numbers[i]);
        }
}

static duet_world *make_hashed_world(duet_shape shape)
{
    duet_world_def def = devices_def(3);
    def.shape = shape;
    def.plan.mode = DUET_MODE_OWN;
    set_variants(&def.plan, "simd grid=hashed");
    return create_world(&def);
}

// Mixed sizes have several levels, far crowds a hashed grid, and what is no number a cell too.
TEST(any_grid_has_an_order)
{
    enum { N = 3000 };
    rng r = {test_seed()};
    fill_poses(&r, N, 3);
    for (uint32_t i = 0; i < N; i += 100)
        poses[i].half_extents[0] = 20.0f;
    poses[7].centre[1] = NAN;
    duet_world_def def = devices_def(3);
    duet_world *world = create_world(&def);
    set_poses(world, N);
    assert_is_by_cell(world, N);
    assert_true(world->grid.n_levels > 1);

    for (uint32_t i = N / 2; i < N; ++i)
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] += 1e6f;
    world = make_hashed_world(DUET_SHAPE_POSES);
    set_poses(world, N);
    uint32_t *order = order_of(world, N);
    assert_int_equal(world->grid.kind, GRID_HASHED);
    assert_is_permutation(order, N);
    for (uint32_t i = 0; i < N; ++i)
        assert_int_equal(order[i] >= N / 2, i >= N / 2);
    duet_free(order);
}

// Cubes of edge 1 that take turns to be in one of two crowds. Bounds, for those of poses are
// widened by so much, far from 0, that they do not have so many cells.
static void order_crowds(rng *r, float apart, double least_cells, double most_cells)
{
    enum { N = 33001 };
    static duet_bounds bounds[N];
    duet_world *world = make_hashed_world(DUET_SHAPE_BOUNDS);
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) {
            bounds[i].lower[k] = (float)rng_below(r, 40) + (i % 2 ? apart : 0.0f);
            bounds[i].upper[k] = bounds[i].lower[k] + 1.0f;
        }
    must(duet_world_set_objects(world, DUET_OBJECT_BOUNDS, bounds, N, ERR));
    assert_is_by_cell(world, N);
    assert_true(number_of_cells(world) > least_cells && number_of_cells(world) < most_cells);
}

TEST(cells_beyond_32_and_beyond_63_bits_are_in_order)
{
    rng r = {test_seed()};
    order_crowds(&r, 1e4f, 0x1p32, 0x1p63);
    order_crowds(&r, 8e6f, 0x1p63, INFINITY);
}

TEST(objects_of_one_cell_are_in_the_order_of_their_ids)
{
    duet_world_def def = devices_def(3);
    duet_world *world = create_world(&def);
    rng r = {test_seed()};
    for (uint32_t i = 0; i < MANY; ++i)
        poses[i] = random_cube(&r, 0, 0.0);
    set_poses(world, MANY);
    assert_is_by_cell(world, MANY);
    assert_true(number_of_cells(world) == 1.0);
    for (uint32_t i = 1; i < MANY; i += 2)
        poses[i].centre[1] = 30.0f;
    set_poses(world, MANY);
    world_forget_grid(world);
    assert_is_by_cell(world, MANY);
}

// Boxes of two sizes, of which several are the widest, and some that are bad.
TEST(threads_find_what_one_finds_of_a_grid_s_needs)
{
    static const uint32_t numbers[] = {0, 1, 127, 128, 129, CAPACITY};
    rng r = {test_seed()};
    thread_pool *threads = must(thread_pool_open(3, ERR));
    fill_poses(&r, CAPACITY, 3);
    for (uint32_t i = 0; i < CAPACITY; i += 30) {
        poses[i].half_extents[i % 3] = i % 4 ? 7.0f : -1.0f;
        memcpy(poses[i].rotation, (const float[]){0, 0, 0, 1}, sizeof poses[i].rotation);
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        grid_objects objects = {.dims = 3, .all = {poses, sizeof *poses, numbers[i], 0}};
        grid_needs one = {0}, all = {0};
        grid_needs_of(&one, &objects, NULL);
        grid_needs_of(&all, &objects, threads);
        assert_memory_equal(&all, &one, offsetof(grid_needs, widest_id));
        assert_int_equal(all.widest_id, one.widest_id);
        assert_memory_equal(all.octave_n, one.octave_n, sizeof one.octave_n);
        assert_memory_equal(all.octave_widest, one.octave_widest, sizeof one.octave_widest);
    }
    thread_pool_close(threads);
}

// ------------------------------------------------------------ worlds that are kept in order

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 100, DUET_SHARE_ONE / 2, DUET_SHARE_ONE};
enum { SHARES = sizeof shares / sizeof *shares };

static known_pairs poses_pairs(uint32_t n, uint32_t dims)
{
    return known_pairs_of(DUET_OBJECT_POSES, poses, n, dims);
}

static duet_world_def ordered_def(uint32_t dims, const char *kernels)
{
    duet_world_def def = devices_def(dims);
    def.ordered = true;
    def.plan = plan_of(DUET_MODE_SLAB, DUET_SHARE_ONE / 2, kernels, kernels);
    return def;
}

// A world like that, and objects for it.
static duet_world *ordered_world(rng *r, uint32_t n)
{
    duet_world_def def = ordered_def(3, "simd");
    fill_poses(r, n, 3);
    return create_world(&def);
}

static void put_in_order(duet_world *world, uint32_t n)
{
    set_poses(world, n);
    uint32_t *order = order_of(world, n);
    duet_pose *old = test_alloc(n * sizeof *old + 1);
    memcpy(old, poses, n * sizeof *old);
    for (uint32_t i = 0; i < n; ++i)
        poses[i] = old[order[i]];
    duet_free(order);
}

static void swap(uint32_t a, uint32_t b)
{
    duet_pose kept = poses[a];
    poses[a] = poses[b];
    poses[b] = kept;
}

static void reverse(uint32_t n)
{
    for (uint32_t i = 0; i < n / 2; ++i)
        swap(i, n - 1 - i);
}

// Some objects come to lie anywhere.
static void stray(rng *r, uint32_t n)
{
    for (uint32_t i = 0; i < n; i += 700)
        swap(i, (uint32_t)rng_between(r, 0, n - 0.5));
}

static void assert_finds_all(duet_world *world, uint32_t n)
{
    const known_pairs truth = poses_pairs(n, world->def.dims);
    for (int s = 0; s < SHARES; ++s) {
        set_share(world, shares[s]);
        set_poses(world, n);
        assert_step_finds(world, truth);
        assert_step_finds(world, truth); // without new objects
    }
}

static void assert_finds_all_in_any_order(duet_world *world, rng *r, uint32_t n)
{
    assert_finds_all(world, n);
    put_in_order(world, n);
    assert_finds_all(world, n);
    if (n > 0)
        stray(r, n);
    assert_finds_all(world, n);
    reverse(n);
    assert_finds_all(world, n);
}

// Takes the devices for ones with memory of their own; host: as they are.
static void set_memory(bool host)
{
    static bool is_known, of_host[2];
    for (int side = 0; side < 2; ++side) {
        bool *told = &default_pair()->devices[side].info.host_memory;
        of_host[side] = is_known ? of_host[side] : *told;
        *told = host && of_host[side];
    }
    is_known = true;
}

TEST(any_order_share_and_number_gives_the_reference_pairs)
{
    static const uint32_t numbers[] = {0, 1, 5, 1023, 5003};
    rng r = {test_seed()};
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        duet_world_def def = ordered_def(dims, "simd");
        duet_world *world = create_world(&def);
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
            fill_poses(&r, numbers[i], dims);
            assert_finds_all_in_any_order(world, &r, numbers[i]);
        }
    }
}

TEST(every_sort_takes_stretches)
{
    enum { N = 5003 };
    static const char *const variants[] = {
        "simd sort=radix", "gpu",         "gpu FROM_IDS=0", "gpu sort=radix", "gpu send=chunks",
        "gpu send=packed", "gpu FUSED=1", "paper"};
    rng r = {test_seed()};
    for (int host = 0; host < 2; ++host)
        for (size_t v = 0; v < sizeof variants / sizeof *variants; ++v) {
            duet_world_def def = ordered_def(3, variants[v]);
            set_memory(host);
            duet_world *world = create_world(&def);
            fill_poses(&r, N, 3);
            put_in_order(world, N);
            stray(&r, N);
            assert_finds_all(world, N);
        }
    set_memory(true);
}

// They go straight to their places there, and boxes are read where they are: of one size and of
// several, in a dense grid and in a hashed one.
TEST(whole_grids_of_ordered_objects_are_right)
{
    enum { N = 3000 };
    static const char *const variants[] = {"gpu FUSED=1 JOINED=1", "gpu grid=hashed", "simd"};
    rng r = {test_seed()};
    for (size_t v = 0; v < sizeof variants / sizeof *variants; ++v) {
        duet_world_def def = ordered_def(3, variants[v]);
        def.plan.mode = DUET_MODE_OWN;
        duet_world *world = create_world(&def);
        fill_poses(&r, N, 3);
        assert_finds_all_in_any_order(world, &r, N);
        for (uint32_t i = 0; i < N; i += 100)
            poses[i].half_extents[0] = 20.0f;
        set_poses(world, N);
        world_forget_grid(world);
        assert_finds_all(world, N);
        assert_true(world->grid.n_levels > 1);
    }
}

// The first words of a part's buffer; on a device with memory of its own they are copied from
// there.
static const uint32_t *words_of(const part *p, const buffer *b, size_t n)
{
    static uint32_t words[8 * CAPACITY];
    if (n == 0)
        return words;
    assert_true(n <= sizeof words / sizeof *words);
    assert_int_equal(clEnqueueReadBuffer(p->device->queue, b->mem, CL_TRUE, 0, n * sizeof *words,
                                         words, 0, NULL, NULL),
                     CL_SUCCESS);
    return words;
}

// No cell may be two work-items' own: they count without atomics.
static uint32_t count_others(duet_world *world, uint32_t n)
{
    const part *p = &world->parts[1];
    set_poses(world, n);
    assert_step_finds(world, poses_pairs(n, 3));
    const uint32_t per_item = p->kernels.hash->per_item, n_items = (n + per_item - 1) / per_item;
    const uint32_t *edges = words_of(p, &p->edges, n_items + (size_t)1);
    for (uint32_t i = 0; i < n_items; ++i)
        assert_true(edges[i] <= edges[i + 1]);
    return words_of(p, &p->counters, COUNTERS)[COUNT_OTHERS];
}

// A CPU's have some.
static bool has_own_cells(duet_world *world)
{
    step_world(world);
    return world->parts[1].kernels.own_cells != NULL;
}

// The first ones of a work-item's 1 024 objects may be in cells that are another's.
TEST(objects_in_order_are_in_their_work_item_s_own_cells)
{
    enum { N = 5003 };
    const uint32_t units = default_pair()->devices[1].info.units;
    default_pair()->devices[1].info.units = 0; // few objects are enough
    rng r = {test_seed()};
    duet_world *world = ordered_world(&r, N);
    assert_finds_all_in_any_order(world, &r, N);
    duet_world_def def = ordered_def(3, "simd");
    def.plan.mode = DUET_MODE_OWN;
    def.plan.share = 0;
    world = create_world(&def);
    put_in_order(world, N);
    if (!has_own_cells(world)) {
        default_pair()->devices[1].info.units = units;
        print_message("this device's work-items have no cells of their own\n");
        skip();
    }
    assert_in_range(count_others(world, N), 0, N / 100);
    for (uint32_t i = 0; i < N; i += 1024) // strays that come first
        swap(i, (uint32_t)rng_between(&r, 0, N - 0.5));
    assert_in_range(count_others(world, N), 1, N / 50);
    reverse(N);
    assert_in_range(count_others(world, N), N / 2, N);
    default_pair()->devices[1].info.units = units;
}

// Each cell and those around it hold hundreds, many more than a lane lists at once.
TEST(crowds_are_found_by_lanes_that_list_first)
{
    enum { N = 1200 };
    rng r = {test_seed()};
    duet_world_def def = ordered_def(3, "gpu FUSED=1 JOINED=1");
    def.plan.mode = DUET_MODE_OWN;
    duet_world *world = create_world(&def);
    fill_poses(&r, N, 3);
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0.0, i % 2 ? 6.0 : 60.0);
    put_in_order(world, N);
    assert_finds_all(world, N);
}

static bool has_stage(const part *p, const char *name)
{
    for (int i = 0; i < p->times.n_stages; ++i)
        if (strcmp(p->times.stages[i].name, name) == 0)
            return true;
    return false;
}

static void assert_zero(const part *p, const buffer *b, size_t n)
{
    const uint32_t *at = words_of(p, b, n);
    for (size_t i = 0; i < n; ++i)
        assert_int_equal(at[i], 0);
}

// A step's counts are zero when it begins: it clears that itself, or the step before did.
static void assert_counts_from_zero(duet_world *world, uint32_t n, const bool clears[2])
{
    set_poses(world, n);
    assert_step_finds(world, poses_pairs(n, 3));
    for (int side = 0; side < 2; ++side) {
        const part *p = &world->parts[side];
        assert_int_equal(has_stage(p, "clear"), clears[side]);
        assert_true(p->zero_words > COUNTERS);
        assert_zero(p, &p->counts, p->zero_words - COUNTERS);
        assert_zero(p, &p->next_counters, COUNTERS);
        if (!clears[side])
            assert_int_equal(p->times.n_launches, 4); // hash, scan_at_once, reorder, search
    }
}

TEST(a_step_leaves_its_counts_at_zero_for_the_next_one)
{
    enum { N = CAPACITY / 4 };
    static const bool both[2] = {true, true}, none[2];
    rng r = {test_seed()};
    duet_world_def def = ordered_def(3, "simd");
    def.plan.mode = DUET_MODE_OWN;
    def.max_pairs = N;
    def.stage_times = true;
    duet_world *world = create_world(&def);
    fill_poses(&r, 4 * N, 3);
    assert_counts_from_zero(world, N, both);
    for (int i = 0; i < 3; ++i)
        assert_counts_from_zero(world, N - i, none);
    assert_counts_from_zero(world, N / 4, none); // another grid, of fewer cells
    for (uint32_t i = 0; i < N; ++i)
        poses[4 * N - 1 - i].centre[0] = 1.0f; // a crowd
    set_poses(world, 4 * N);
    must_fail(duet_world_step(world, &(duet_result){0}, ERR), DUET_STATUS_TOO_MANY, "");
    assert_counts_from_zero(world, N, both);
    assert_counts_from_zero(world, N, none);
}

// Modes take other kernels, which leave other sums behind.
TEST(a_world_may_change_its_mode_from_step_to_step)
{
    enum { N = CAPACITY };
    static const duet_mode modes[] = {DUET_MODE_OWN,  DUET_MODE_SHARED, DUET_MODE_OWN,
                                      DUET_MODE_SLAB, DUET_MODE_SHARED, DUET_MODE_SLAB};
    rng r = {test_seed()};
    duet_world *world = ordered_world(&r, N);
    const known_pairs truth = poses_pairs(N, 3);
    for (size_t i = 0; i < sizeof modes / sizeof *modes; ++i) {
        duet_plan plan = *duet_world_get_plan(world);
        plan.mode = modes[i];
        must(duet_world_set_plan(world, &plan, ERR));
        set_poses(world, N);
        assert_step_finds(world, truth);
    }
    assert_true(world->parts[1].scan.stamp > 1);
}

// B's slab has rows of cells, but no object is in them, and B takes none: what it counted when it
// had some is not told again.
TEST(a_device_that_takes_nothing_finds_nothing)
{
    enum { N = 2 * INPUT_BLOCK }; // A's own range ends with the last block
    rng r = {test_seed()};
    duet_world_def def = ordered_def(3, "gpu FROM_IDS=0");
    def.has_world = true;
    def.upper[0] = def.upper[1] = def.upper[2] = 100.0f;
    duet_world *world = create_world(&def);
    fill_poses(&r, N, 3);
    put_in_order(world, N);
    set_poses(world, N);
    const known_pairs truth = poses_pairs(N, 3);
    for (int round = 0; round < 2; ++round) {
        set_share(world, DUET_SHARE_ONE / 10 * 9); // B has fewer than an empty slab has space for
        assert_true(step_world(world).spans[1].n > 0);
        set_share(world, DUET_SHARE_ONE - 1);
        for (int i = 0; i < 3; ++i) {
            const duet_result result = step_world(world);
            assert_int_equal(world->ranges.selections[1].n_ranges, 1);
            assert_int_equal(result.spans[1].n, 0);
            assert_found(&result, truth);
        }
    }
}

// Giants make the cells wide, and a crowd makes one cell hold half of all.
TEST(giants_and_crowds_are_found)
{
    enum { N = 3000 };
    rng r = {test_seed()};
    duet_world *world = ordered_world(&r, N);
    for (uint32_t i = 0; i < N; i += 1000)
        poses[i].half_extents[1] = 3.0f;
    assert_finds_all_in_any_order(world, &r, N);
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = i % 10 == 0 ? 1.0f : 1000.0f * poses[i].centre[k];
    assert_finds_all_in_any_order(world, &r, N);
}

// The devices alone compute cells of objects in origin cells, and mark strays by them.
TEST(objects_in_origin_cells_are_found_in_any_order)
{
    enum { N = 3000 };
    rng r = {test_seed()};
    duet_world_def def = ordered_def(3, "simd");
    def.origin_edge = 4.0f;
    duet_world *world = create_world(&def);
    fill_poses(&r, N, 3);
    for (uint32_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) // so that a cell and an offset are the same number
            poses[i].centre[k] = rintf(poses[i].centre[k] * 1024.0f) / 1024.0f;
    assert_finds_all_in_any_order(world, &r, N);
    assert_in_range(world->ranges.selections[0].n_ranges, 1, SELECTION_RANGES);
}

static uint32_t count_taken(const duet_world *world, int side)
{
    return selection_count(&world->ranges.selections[side]);
}

// A device takes of objects in order its half and the ghosts at the border.
TEST(a_device_takes_its_own_half_and_the_blocks_with_strays)
{
    enum { N = CAPACITY };
    rng r = {test_seed()};
    for (int host = 0; host < 2; ++host) {
        set_memory(host);
        duet_world *world = ordered_world(&r, N);
        set_poses(world, N);
        step_world(world);
        assert_int_equal(count_taken(world, 0), N); // in no order
        assert_int_equal(count_taken(world, 1), N);
        put_in_order(world, N);
        set_poses(world, N);
        step_world(world); // the same amount as before, since that was wanted
        step_world(world);
        assert_in_range(count_taken(world, 0), N * 4 / 10, N * 7 / 10);
        assert_in_range(count_taken(world, 1), N * 4 / 10, N * 6 / 10);
        swap(10, N - 10);
        set_poses(world, N);
        step_world(world);
        assert_in_range(count_taken(world, 0), N * 4 / 10, N * 8 / 10);
        assert_in_range(count_taken(world, 1), N * 5 / 10, N * 7 / 10);
    }
    set_memory(true);
}

// Objects that drift over the cut are in blocks that nobody guessed: the step finds that out.
TEST(objects_that_move_are_found_in_every_step)
{
    enum { N = 6000, STEPS = 8 };
    rng r = {test_seed()};
    for (int host = 0; host < 2; ++host) {
        set_memory(host);
        duet_world *world = ordered_world(&r, N);
        put_in_order(world, N);
        for (int i = 0; i < STEPS; ++i) {
            set_poses(world, N);
            assert_step_finds(world, poses_pairs(N, 3));
            for (uint32_t id = 0; id < N; ++id)
                for (int k = 0; k < 3; ++k)
                    poses[id].centre[k] += (float)rng_between(&r, -0.5, 0.5);
            if (i == STEPS / 2)
                reverse(N);
        }
    }
    set_memory(true);
}

// ------------------------------------------------------------ guesses

enum { BLOCKS = 100, OWN = BLOCKS / 2 };

// Slabs of 100 blocks in order, cut behind so many objects, with 3 blocks of ghosts.
static void begin_ranges_behind(input_ranges *s, uint32_t homes, bool expected_new)
{
    const part_range slabs[2] = {
        {.key_to = 530, .home_to = 500, .homes = homes, .expected_ghosts = 3000},
        {.key_from = 500, .key_to = 1000, .home_to = 1000}};
    const input_ranges before = *s;
    must(input_ranges_begin(s, BLOCKS * INPUT_BLOCK, slabs, ERR));
    assert_int_equal(memcmp(&before, s, sizeof before) != 0, expected_new);
}

static void begin_ranges(input_ranges *s, bool expected_new)
{
    begin_ranges_behind(s, OWN * INPUT_BLOCK, expected_new);
}

static uint32_t taken_from_other(const input_ranges *s, int side)
{
    const uint32_t own = side == 0 ? s->cut : s->n - s->cut;
    return (selection_count(&s->selections[side]) - own) / INPUT_BLOCK;
}

static bool guesses(input_ranges *s, const uint32_t *blocks, uint32_t n)
{
    static uint32_t marked[2][BLOCKS];
    static uint32_t stamp;
    const block_requests marks[2] = {{marked[0], ++stamp}, {marked[1], stamp}};
    for (uint32_t i = 0; i < n; ++i)
        marked[blocks[i] < OWN ? 0 : 1][blocks[i]] = stamp;
    return input_ranges_held(s, marks);
}

TEST(a_guess_follows_what_was_wanted)
{
    static const uint32_t ghosts[] = {50, 51, 52}, far[] = {50, 51, 52, 70},
                          back[] = {50, 51, 70, 10};
    input_ranges s = {0};
    begin_ranges(&s, true);
    assert_int_equal(taken_from_other(&s, 0), 3); // in order the first guess is right
    assert_int_equal(taken_from_other(&s, 1), 0);
    assert_true(guesses(&s, ghosts, 3));
    begin_ranges(&s, false);
    assert_false(guesses(&s, far, 4));
    assert_int_equal(taken_from_other(&s, 0), 4); // exactly, or with the gap, which is long
    assert_true(guesses(&s, far, 4));
    assert_false(guesses(&s, back, 4)); // a layer of three more on both sides
    assert_int_equal(taken_from_other(&s, 0), 5 + 7);
    assert_int_equal(taken_from_other(&s, 1), 7);
    assert_true(guesses(&s, ghosts, 2)); // less than was guessed
    assert_true(taken_from_other(&s, 0) <= 5 && taken_from_other(&s, 1) == 0);
    input_ranges_close(&s);
}

// The data that B takes of A is one more command for a device with memory of its own.
TEST(b_takes_none_of_as_objects_where_all_are_in_order)
{
    static const uint32_t more[] = {0, 1, INPUT_BLOCK / 2, INPUT_BLOCK - 1};
    for (size_t i = 0; i < sizeof more / sizeof *more; ++i) {
        input_ranges s = {0};
        begin_ranges_behind(&s, OWN * INPUT_BLOCK + more[i], true);
        assert_int_equal(s.cut, OWN * INPUT_BLOCK);
        assert_int_equal(taken_from_other(&s, 0), more[i] > 72 ? 4 : 3); // 72 short of 3 blocks
        assert_int_equal(taken_from_other(&s, 1), 0);
        input_ranges_close(&s);
    }
}

// One launch reads them.
TEST(blocks_beside_the_own_range_are_one_with_it)
{
    static const uint32_t beside[] = {50, 51, 48, 49}, apart[] = {60, 40};
    input_ranges s = {0};
    begin_ranges(&s, true);
    assert_false(guesses(&s, beside, 4));
    const selection *a = &s.selections[0], *b = &s.selections[1];
    assert_true(a->n_ranges == 1 && a->ranges[0].from == 0 && a->own == 0);
    assert_int_equal(a->ranges[0].to, 52 * INPUT_BLOCK);
    assert_true(b->n_ranges == 1 && b->ranges[0].from == 48 * INPUT_BLOCK && b->own == 0);
    s.margin = 0;
    assert_false(guesses(&s, apart, 2));
    assert_true(a->n_ranges == 2 && a->own == 0 && b->n_ranges == 2 && b->own == 1);
    assert_int_equal(b->ranges[1].from, s.cut);
    input_ranges_close(&s);
}

// Blocks far apart have more around them than is requested, and keep it.
TEST(the_same_guess_is_no_new_one)
{
    static const uint32_t ghosts[] = {50, 51, 52}, apart[] = {60, 75, 90}, moved[] = {61, 76, 91};
    input_ranges s = {0};
    begin_ranges(&s, true);
    assert_true(guesses(&s, ghosts, 3));
    assert_false(guesses(&s, apart, 3));
    assert_false(guesses(&s, moved, 3));
    const selection first[2] = {s.selections[0], s.selections[1]};
    for (int i = 0; i < 3; ++i)
        assert_true(guesses(&s, moved, 3));
    assert_memory_equal(s.selections, first, sizeof first);
    input_ranges_close(&s);
}

TEST(a_bad_object_is_named_wherever_it_strays)
{
    enum { N = 5003 };
    rng r = {test_seed()};
    duet_world *world = ordered_world(&r, N);
    put_in_order(world, N);
    poses[N - 1].centre[2] = NAN;
    poses[N - 2].centre[0] = INFINITY;
    poses[40].half_extents[0] = -1.0f;
    for (int s = 0; s < SHARES; ++s) {
        duet_result result;
        set_share(world, shares[s]);
        set_poses(world, N);
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 40 ");
        assert_says(ERR->text, "3 such objects");
    }
}

// ------------------------------------------------------------ profiles

static void assert_is_called(duet_world *world, const char *effects)
{
    profile_subject p;
    set_poses(world, CAPACITY);
    must(profile_subject_read(world, &p, ERR));
    if (effects)
        assert_string_equal(p.workload.effects, effects);
    else
        assert_null(p.workload.effects);
}

// A profile is of objects at random, in order, or in an order with strays.
TEST(a_workload_tells_how_many_objects_stray)
{
    rng r = {test_seed()};
    duet_world_def def = ordered_def(3, "simd");
    duet_world *world = create_world(&def);
    def.ordered = false;
    duet_world *plain = create_world(&def);
    fill_poses(&r, CAPACITY, 3);
    assert_is_called(world, NULL);
    put_in_order(world, CAPACITY);
    assert_is_called(world, "ordered");
    assert_is_called(plain, NULL);
    for (int k = 0; k < CAPACITY / 8; ++k)
        swap((uint32_t)rng_between(&r, 0, CAPACITY - 0.5),
             (uint32_t)rng_between(&r, 0, CAPACITY - 0.5));
    assert_is_called(world, "ordered strays");
}
