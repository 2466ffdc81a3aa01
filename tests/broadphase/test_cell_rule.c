// SPDX-License-Identifier: MIT
// The cell rule (docs/accuracy.md, "Cells"): whatever an object's size is beside
// the spacing of floats where it lies, no search loses a pair. The truth is a sweep
// along x over whole numbers, which knows no cells.
#include "support/test.h"

#include "support/agreement.h"
#include "support/devices.h"

enum { FEW = 220, MANY = 20000, MAGNITUDES = 40, QUANTA_BITS = 24 };

// ------------------------------------------------------------ boxes in whole numbers

// Corners in halves of a unit, so that a centre is whole, too.
typedef struct lattice_box {
    int64_t lower[3], upper[3];
    uint32_t id;
} lattice_box;

typedef enum kind { ULPS, POINTS, PLATES, NEEDLES, MIXED, N_KINDS } kind;
static const char *const kind_names[N_KINDS] = {"1 to 4 units", "points", "plates", "needles",
                                                "1 to 500 units"};

// How wide along an axis, in units.
static int64_t width_of(kind what, rng *r, int axis, int special)
{
    switch (what) {
    case ULPS:
        return 1 + rng_below(r, 4);
    case POINTS:
        return 0;
    case PLATES:
        return axis == special ? rng_below(r, 2) : 12;
    case NEEDLES:
        return axis == special ? 16 : rng_below(r, 2);
    default:
        return 1 + rng_below(r, 1u << rng_below(r, 10));
    }
}

// Around `base` units from 0 on each axis, so near each other that many touch.
static void scatter(lattice_box *boxes, uint32_t n, kind what, int64_t base, uint32_t spread,
                    uint32_t dims, rng *r)
{
    for (uint32_t i = 0; i < n; ++i) {
        int special = (int)rng_below(r, dims);
        boxes[i] = (lattice_box){.id = i};
        for (int k = 0; k < (int)dims; ++k) {
            int64_t width = width_of(what, r, k, special);
            int64_t lower = base + rng_below(r, spread) - spread / 2;
            boxes[i].lower[k] = 2 * lower;
            boxes[i].upper[k] = 2 * (lower + width);
        }
    }
}

static int by_lower_x(const void *left, const void *right)
{
    const lattice_box *p = left, *q = right;
    return (p->lower[0] > q->lower[0]) - (p->lower[0] < q->lower[0]);
}

static bool share_a_point(const lattice_box *a, const lattice_box *b)
{
    for (int k = 0; k < 3; ++k)
        if (a->lower[k] > b->upper[k] || b->lower[k] > a->upper[k])
            return false;
    return true;
}

// The pair hash of all that touch, and their number. Sorts the boxes.
static uint64_t sweep(lattice_box *boxes, uint32_t n, uint64_t *n_pairs)
{
    uint64_t hash = 0;
    *n_pairs = 0;
    qsort(boxes, n, sizeof *boxes, by_lower_x);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = i + 1; j < n && boxes[j].lower[0] <= boxes[i].upper[0]; ++j) {
            if (!share_a_point(&boxes[i], &boxes[j]))
                continue;
            uint32_t a = boxes[i].id, b = boxes[j].id;
            duet_pair pair = {a < b ? a : b, a < b ? b : a};
            hash += duet_pairs_hash(&pair, 1);
            ++*n_pairs;
        }
    return hash;
}

// ------------------------------------------------------------ as the devices get them

static float scaled(int64_t halves, int exponent)
{
    double exact = ldexp((double)halves, exponent - 1);
    assert_true((double)(float)exact == exact); // else the scene is another one
    return (float)exact;
}

static duet_bounds bounds_of(const lattice_box *box, int exponent)
{
    duet_bounds b = {{0}, {0}};
    for (int k = 0; k < 3; ++k) {
        b.lower[k] = scaled(box->lower[k], exponent);
        b.upper[k] = scaled(box->upper[k], exponent);
    }
    return b;
}

// The lower corner becomes the centre, which is as exact; widths stay.
static duet_pose pose_of(const lattice_box *box, int exponent)
{
    duet_pose pose = {.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = scaled(box->lower[k], exponent);
        pose.half_extents[k] = scaled(box->upper[k] - box->lower[k], exponent - 1);
    }
    return pose;
}

// Corners about the same centre as the pose's.
static void centre_on_lower(lattice_box *box)
{
    for (int k = 0; k < 3; ++k) {
        int64_t half = (box->upper[k] - box->lower[k]) / 2;
        box->upper[k] = box->lower[k] + half;
        box->lower[k] -= half;
    }
}

// ------------------------------------------------------------ plans

static const struct {
    duet_mode mode;
    const char *variant;
    bool needs_boxes;
    bool in_2d; // tried there too
} ways[] = {
    {DUET_MODE_SHARED, "auto", false, true},
    {DUET_MODE_SHARED, "gpu grid=hashed", false, false},
    {DUET_MODE_SHARED, "gpu sort=radix grid=uniform", false, false},
    {DUET_MODE_SHARED, "paper", false, false},
    {DUET_MODE_OWN, "gpu", false, false},
    {DUET_MODE_OWN, "auto grid=dense", false, false},
    {DUET_MODE_OWN, "gpu FUSED=1 sort=radix grid=hashed", true, false},
    {DUET_MODE_OWN, "simd", false, true},
    {DUET_MODE_OWN, "simd grid=hashed", false, true},
    {DUET_MODE_OWN, "simd grid=uniform", false, false},
    {DUET_MODE_SLAB, "simd", false, false},
    {DUET_MODE_SLAB, "gpu FUSED=1", true, false},
    {DUET_MODE_SLAB, "paper", false, true},
};
enum { N_WAYS = sizeof ways / sizeof *ways };

static void step(duet_world *world, size_t way, const char *scene, uint64_t hash, uint64_t n_pairs)
{
    duet_result result;
    duet_plan plan = {.mode = ways[way].mode, .share = DUET_SHARE_ONE / 2};
    // A's kernels are compiled apart from B's, which takes most of the test's time.
    strcpy(plan.variant_a, plan.mode == DUET_MODE_SHARED ? ways[way].variant : "gpu");
    strcpy(plan.variant_b, ways[way].variant);
    must(duet_world_set_plan(world, &plan, ERR));
    must(duet_world_step(world, &result, ERR));
    if (result.pairs != n_pairs || duet_result_get_hash(&result) != hash)
        fail_msg("%s, %s %s: %" PRIu64 " pairs, and %" PRIu64 " touch", scene,
                 duet_mode_name(plan.mode), ways[way].variant, result.pairs, n_pairs);
}

static duet_world *make_world(duet_shape shape, uint32_t dims)
{
    duet_world_def def = devices_def(dims);
    def.shape = shape;
    return create_world(&def);
}

static void set_objects(duet_world *world, duet_shape shape, const lattice_box *boxes, uint32_t n,
                        int exponent)
{
    if (shape == DUET_SHAPE_BOUNDS) {
        duet_bounds *rows = must(duet_world_map_objects(world, DUET_OBJECT_BOUNDS, n, ERR));
        for (uint32_t i = 0; i < n; ++i)
            rows[i] = bounds_of(&boxes[i], exponent);
    } else {
        duet_pose *rows = must(duet_world_map_objects(world, DUET_OBJECT_POSES, n, ERR));
        for (uint32_t i = 0; i < n; ++i)
            rows[i] = pose_of(&boxes[i], exponent);
    }
}

// ------------------------------------------------------------ tests

// The unit is the spacing of floats at the magnitude, or the least float there is.
// In 3D every other way is taken, so that two magnitudes take them all.
static void check_magnitude(duet_world *world, duet_shape shape, uint32_t dims, kind what,
                            int magnitude, size_t first_way, rng *r)
{
    lattice_box boxes[FEW];
    int exponent = -149 + (int)lround(magnitude * 251.0 / (MAGNITUDES - 1));
    bool halves_exist = shape == DUET_SHAPE_BOUNDS || exponent > -149;
    int64_t base = (int64_t)0xC00000 - (int64_t)rng_below(r, 0x300000);
    base = magnitude % 3 == 0 ? 0 : magnitude % 3 == 1 ? base : -base;
    scatter(boxes, FEW, what, base, dims == 3 ? 18 : 60, dims, r);
    for (uint32_t i = 0; !halves_exist && i < FEW; ++i)
        for (uint32_t k = 0; k < dims; ++k)
            boxes[i].upper[k] += (boxes[i].upper[k] - boxes[i].lower[k]) % 4;
    set_objects(world, shape, boxes, FEW, exponent);
    for (uint32_t i = 0; shape == DUET_SHAPE_POSES && i < FEW; ++i)
        centre_on_lower(&boxes[i]);
    uint64_t n_pairs;
    uint64_t hash = sweep(boxes, FEW, &n_pairs);
    assert_true(n_pairs > 0);
    char scene[128];
    snprintf(scene, sizeof scene, "%uD %s of 2^%d, %s", dims,
             shape == DUET_SHAPE_BOUNDS ? "bounds" : "poses", exponent, kind_names[what]);
    for (size_t way = 0; way < N_WAYS; ++way) {
        bool its_turn = dims == 2 ? ways[way].in_2d : way % 2 == first_way;
        if (its_turn && test_takes(way / 2, 5) &&
            (shape == DUET_SHAPE_POSES || !ways[way].needs_boxes))
            step(world, way, scene, hash, n_pairs);
    }
}

static void check_shape(duet_shape shape, uint32_t dims)
{
    rng r = rng_seed(test_seed());
    duet_world *world = make_world(shape, dims);
    for (int magnitude = 0; magnitude < MAGNITUDES; ++magnitude)
        check_magnitude(world, shape, dims, (kind)(magnitude % N_KINDS), magnitude,
                        (size_t)magnitude % 2, &r);
}

TEST(bounds_of_any_width_in_spacings_of_floats_are_found)
{
    check_shape(DUET_SHAPE_BOUNDS, 2);
    check_shape(DUET_SHAPE_BOUNDS, 3);
}

TEST(poses_of_any_width_in_spacings_of_floats_are_found)
{
    check_shape(DUET_SHAPE_POSES, 2);
    check_shape(DUET_SHAPE_POSES, 3);
}

// The devices count as candidates what their bounds say, object by object.
TEST(candidates_among_tiny_boxes_are_those_of_the_bounds)
{
    rng r = rng_seed(test_seed());
    static const int exponents[] = {-140, -60, 0, 40};
    for (int i = 0; i < 4; ++i) {
        lattice_box boxes[FEW];
        duet_pose poses[FEW];
        scatter(boxes, FEW, i % 2 ? ULPS : MIXED, 0xA00000, 40, 3, &r);
        for (uint32_t k = 0; k < FEW; ++k)
            poses[k] = pose_of(&boxes[k], exponents[i]);
        duet_world_def def = devices_def(3);
        def.rotated = i >= 2;
        assert_true(agreement_check(&def, poses, FEW) > 0);
    }
}

// Origin cells: a unit is a quantum, and boxes lie on both sides of cells' borders.
TEST(placed_boxes_of_a_few_quanta_are_found)
{
    rng r = rng_seed(test_seed());
    static const int64_t cells[] = {0, -1, 123456789, -(1 << 30) + 4, (1 << 30) - 4};
    for (int i = 0; i < 5; ++i) {
        lattice_box boxes[FEW];
        duet_large_pose placed[FEW];
        scatter(boxes, FEW, (kind)i, cells[i] * (INT64_C(1) << QUANTA_BITS), 18, 3, &r);
        for (uint32_t b = 0; b < FEW; ++b) {
            lattice_box in_cell = boxes[b];
            memset(&placed[b], 0, sizeof placed[b]);
            for (int k = 0; k < 3; ++k) {
                int64_t at = boxes[b].lower[k] / 2;
                int64_t cell = at >> QUANTA_BITS;
                in_cell.lower[k] -= 2 * cell * (INT64_C(1) << QUANTA_BITS);
                in_cell.upper[k] -= 2 * cell * (INT64_C(1) << QUANTA_BITS);
                placed[b].cell[k] = (int32_t)cell;
            }
            placed[b].pose = pose_of(&in_cell, -QUANTA_BITS);
            centre_on_lower(&boxes[b]);
        }
        uint64_t n_pairs;
        sweep(boxes, FEW, &n_pairs);
        duet_world_def def = devices_def(3);
        def.origin_edge = 1.0f;
        def.rotated = false;
        assert_int_equal(agreement_check(&def, placed, FEW), n_pairs);
        if (i % 2) {
            def.has_world = true; // a box whose corner is no quantum
            for (int k = 0; k < 3; ++k) {
                def.lower[k] = (double)cells[i] - 0.1;
                def.upper[k] = (double)cells[i] + 0.1;
            }
            assert_int_equal(agreement_check(&def, placed, FEW), n_pairs);
        }
    }
}

TEST(thousands_of_boxes_an_ulp_wide_are_found_by_the_default_plan)
{
    rng r = rng_seed(test_seed());
    lattice_box *boxes = test_alloc(MANY * sizeof *boxes);
    duet_world *world = make_world(DUET_SHAPE_BOUNDS, 3);
    for (int round = 0; round < 2; ++round) {
        // 2^24 and more: a float there is even, then any number near 1e7.
        scatter(boxes, MANY, ULPS, 10000000, 61, 3, &r);
        set_objects(world, DUET_SHAPE_BOUNDS, boxes, MANY, round == 0 ? 1 : 0);
        uint64_t n_pairs;
        uint64_t hash = sweep(boxes, MANY, &n_pairs);
        for (size_t way = 0; way < N_WAYS; ++way)
            if (!ways[way].needs_boxes && test_takes(way / 2, 5))
                step(world, way, "20 000 boxes", hash, n_pairs);
    }
}
