// SPDX-License-Identifier: MIT
// Every search finds the reference's pairs, whatever the objects are and
// wherever they are cut.
#include "support/devices.h"
#include "support/test.h"

enum { MOST = 2500 };

typedef struct crowd {
    uint32_t dims;
    duet_shape shape;
    bool rotated;
    bool mixed; // sizes over six octaves
    uint32_t n;
    duet_pose poses[MOST];
    duet_bounds bounds[MOST];
} crowd;

static duet_pose random_pose(rng *r, double width, bool rotated)
{
    duet_pose p = {.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        // every other object lies on a lattice, where boxes touch
        double at = rng_between(r, -width, width);
        p.centre[k] = (float)(rng_below(r, 2) ? at : (double)(int)at);
        p.half_extents[k] = rng_below(r, 2) ? 0.5f : (float)rng_between(r, 0, 0.5);
    }
    for (int k = 0; rotated && k < 4; ++k)
        p.rotation[k] = (float)rng_normal(r);
    return p;
}

static void fill(crowd *c, rng *r, double width)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        c->poses[i] = random_pose(r, width, c->rotated && rng_below(r, 4));
        float scale = c->mixed ? (float)(1u << rng_below(r, 7)) / 16 : 1;
        for (int k = 0; k < 3; ++k)
            c->poses[i].half_extents[k] *= scale;
        c->bounds[i] = bounds_of_upright(&c->poses[i]);
    }
}

static duet_world *open_world(duet_device_pair *pair, const crowd *c)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.dims = c->dims;
    def.shape = c->shape;
    def.rotated = c->rotated;
    return create_world(&def);
}

static void set_objects(duet_world *world, const crowd *c)
{
    if (c->shape == DUET_SHAPE_POSES)
        must(duet_world_set_objects(world, DUET_OBJECT_POSES, c->poses, c->n, ERR));
    else
        must(duet_world_set_objects(world, DUET_OBJECT_BOUNDS, c->bounds, c->n, ERR));
}

static void assert_finds(duet_world *world, const crowd *c, const char *a, const char *b,
                         uint32_t share, duet_mode mode)
{
    duet_plan plan = plan_of(mode, share, a, b);
    duet_result result = step_by(world, &plan);
    const reference_objects objects = {
        .dims = c->dims, .shape = c->shape, .n = c->n, .poses = c->poses, .bounds = c->bounds};
    uint64_t n_pairs, hash = reference_hash(&objects, REFERENCE_COLUMNS, &n_pairs);
    if (result.pairs != n_pairs || duet_result_get_hash(&result) != hash)
        fail_msg("%uD shape %d rotated %d n %u, %s and %s at %u: %" PRIu64 " pairs, not %" PRIu64,
                 c->dims, (int)c->shape, c->rotated, c->n, a, b, share, result.pairs, n_pairs);
}

static const uint32_t shares[] = {0, 1, 6554, 32768, DUET_SHARE_ONE};

// From a few cells to many, so that grids of one, two and three cells an axis
// are among them.
static const double widths[] = {0.1, 1.2, 2.0, 3.0, 20.0};

// A has the same search each time: its kernels are compiled apart from B's, which takes
// most of the test's time.
static void try_crowds(const char *search, crowd *c, rng *r)
{
    static const uint32_t counts[] = {0, 1, 2, 7, 8, 9, 100, 300, 1501};
    duet_world *world = open_world(default_pair(), c);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        for (size_t w = 0; w < sizeof widths / sizeof widths[0]; ++w) {
            if (counts[i] > 300 && widths[w] < 3.0)
                continue; // the reference would take long
            c->n = counts[i];
            fill(c, r, widths[w]);
            set_objects(world, c);
            uint32_t share = shares[rng_below(r, sizeof shares / sizeof shares[0])];
            assert_finds(world, c, "gpu", search, share, DUET_MODE_OWN);
        }
    }
}

static void try_search(const char *search)
{
    rng r = rng_seed(test_seed());
    static crowd c;
    for (c.dims = 2; c.dims <= 3; ++c.dims) {
        for (int kind = 0; kind < 3; ++kind) {
            c.shape = kind < 2 ? DUET_SHAPE_POSES : DUET_SHAPE_BOUNDS;
            c.rotated = kind == 0;
            if (test_takes(c.dims + (uint64_t)kind, 4))
                try_crowds(search, &c, &r);
        }
    }
}

// Unit boxes side by side, `width` along each axis, that touch in the planes of zero.
static void fill_around_zero(crowd *c, int width)
{
    c->n = 0;
    for (int i = 0; i < width * width * width; ++i) {
        const int at[] = {i % width, i / width % width, i / width / width};
        duet_bounds *b = &c->bounds[c->n++];
        for (int k = 0; k < 3; ++k) {
            b->lower[k] = (float)(at[k] - width / 2);
            b->upper[k] = at[k] + 1 == width / 2 ? -0.0f : b->lower[k] + 1;
        }
    }
}

TEST(boxes_touch_where_one_ends_at_minus_zero)
{
    static crowd c = {.dims = 3, .shape = DUET_SHAPE_BOUNDS};
    duet_world *world = open_world(default_pair(), &c);
    for (int width = 2; width <= 8;
         width += 6) { // narrow grids, and those that eight are sought in
        fill_around_zero(&c, width);
        set_objects(world, &c);
        assert_finds(world, &c, "gpu", "simd", 0, DUET_MODE_OWN);
        assert_finds(world, &c, "gpu", "simd", DUET_SHARE_ONE, DUET_MODE_OWN);
    }
}

TEST(lanes_find_the_references_pairs)
{
    try_search("simd");
}

TEST(listed_candidates_give_the_same_pairs)
{
    rng r = rng_seed(test_seed());
    static crowd c = {.shape = DUET_SHAPE_POSES, .rotated = true};
    for (c.dims = 2; c.dims <= 3; ++c.dims)
        if (test_takes(c.dims, 2))
            try_crowds("simd FUSED=0", &c, &r);
}

TEST(rows_find_the_references_pairs)
{
    try_search("gpu");
}

TEST(the_papers_search_finds_the_references_pairs)
{
    try_search("paper");
}

static void try_sizes(const char *search)
{
    rng r = rng_seed(test_seed());
    static crowd c = {.mixed = true};
    for (c.dims = 2; c.dims <= 3; ++c.dims) {
        for (int kind = 0; kind < 2; ++kind) {
            c.shape = kind ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES;
            c.rotated = kind == 0;
            if (test_takes(c.dims + (uint64_t)kind, 3))
                try_crowds(search, &c, &r);
        }
    }
}

TEST(lanes_find_pairs_of_all_sizes)
{
    try_sizes("simd grid=dense");
    try_sizes("simd grid=hashed");
}

// Devices of several threads put the objects of a cell into no certain order.
TEST(parts_agree_where_a_cell_is_cut)
{
    static const char *const searches[] = {"gpu", "simd", "paper"};
    rng r = rng_seed(test_seed());
    static crowd c = {.dims = 3, .shape = DUET_SHAPE_POSES, .rotated = true, .n = MOST};
    duet_world *world = open_world(kept(duet_device_pair_open("pocl:0,pocl:0", ERR)), &c);
    fill(&c, &r, 4.0);
    set_objects(world, &c);
    for (int round = 0; round < 9; ++round)
        assert_finds(world, &c, searches[round % 3], searches[round / 3 % 3],
                     rng_below(&r, DUET_SHARE_ONE), round % 2 ? DUET_MODE_SLAB : DUET_MODE_OWN);
}
