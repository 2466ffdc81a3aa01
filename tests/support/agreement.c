// SPDX-License-Identifier: MIT
#include "support/agreement.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/test.h"

#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/sat_frame.h"
#include "runtime/scene/reference.h"
#include "support/narrow_float.h"

enum { EACH_WITH_EACH_LIMIT = 2000 };

// The plans that may be: hashed grids have no rows to cut slabs from.
static const struct {
    duet_mode mode;
    const char *variant;
} ways[] = {
    {DUET_MODE_SHARED, "auto"},
    {DUET_MODE_SHARED, "gpu sort=radix grid=uniform"},
    {DUET_MODE_SHARED, "gpu grid=hashed"},
    {DUET_MODE_SHARED, "paper"},
    {DUET_MODE_OWN, "gpu"},
    {DUET_MODE_OWN, "auto grid=dense"},
    {DUET_MODE_OWN, "gpu FUSED=1 sort=radix grid=hashed"},
    {DUET_MODE_OWN, "paper"},
    {DUET_MODE_OWN, "simd"},
    {DUET_MODE_OWN, "simd grid=hashed"},
    {DUET_MODE_SHARED, "simd sort=radix"},
    {DUET_MODE_SLAB, "simd"},
    {DUET_MODE_SLAB, "gpu FUSED=1"},
    {DUET_MODE_SLAB, "paper"},
};

// Each way is tried with one of these and with halves. A sample is every third way, and
// has all of them.
static const uint32_t shares[] = {0, 1, DUET_SHARE_ONE};

typedef struct check {
    const duet_world_def *def;
    const void *objects;
    uint32_t n;
    reference_found truth;
    uint64_t hash;       // the true pairs'
    uint64_t candidates; // candidates as the devices' bounds have it
    uint64_t undecided;  // open pairs as the devices' arithmetic leaves them
} check;

static int compare_pairs(const void *left, const void *right)
{
    const duet_pair *p = left, *q = right;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

static duet_pair *sorted_pairs(const duet_result *result)
{
    duet_pair *pairs = malloc((result->pairs + 1) * sizeof *pairs);
    assert_non_null(pairs);
    for (uint64_t i = 0; i < result->pairs; ++i)
        pairs[i] = duet_result_get_pair(result, i);
    if (result->pairs > 0)
        qsort(pairs, result->pairs, sizeof *pairs, compare_pairs);
    return pairs;
}

static void print_objects(const check *c, duet_pair pair)
{
    if (c->def->shape != DUET_SHAPE_POSES)
        return;
    hard_pair both = {*origin_pose(c->objects, c->def->origin_edge, pair.a),
                      *origin_pose(c->objects, c->def->origin_edge, pair.b)};
    hard_pair_print(&both, c->def->dims);
}

static void fail_at(const check *c, const duet_plan *plan, const char *what, duet_pair pair)
{
    print_objects(c, pair);
    fail_msg("%s %s, share %" PRIu32 ": pair %" PRIu32 " %" PRIu32 " is %s",
             duet_mode_name(plan->mode), plan->variant_b, plan->share, pair.a, pair.b, what);
}

static void find_difference(const check *c, const duet_plan *plan, const duet_result *result)
{
    duet_pair *found = sorted_pairs(result);
    const duet_pair *truth = c->truth.pairs;
    uint64_t i = 0;
    while (i < result->pairs && i < c->truth.n && compare_pairs(&found[i], &truth[i]) == 0)
        ++i;
    bool missed = i < c->truth.n && (i == result->pairs || compare_pairs(&found[i], &truth[i]) > 0);
    if (missed)
        fail_at(c, plan, "missed", truth[i]);
    if (i < result->pairs)
        fail_at(c, plan,
                i > 0 && compare_pairs(&found[i], &found[i - 1]) == 0 ? "found twice"
                                                                      : "no collision",
                found[i]);
    fail_msg("the hash of equal pairs differs");
}

static void step(check *c, duet_world *world, const duet_plan *plan)
{
    const duet_result result = step_by(world, plan);
    if (result.pairs != c->truth.n || duet_result_get_hash(&result) != c->hash)
        find_difference(c, plan, &result);
    if (result.candidates != c->candidates || result.undecided != c->undecided)
        fail_msg("%s %s, share %" PRIu32 ": %" PRIu64 " candidates and %" PRIu64
                 " undecided; expected %" PRIu64 " and %" PRIu64,
                 duet_mode_name(plan->mode), plan->variant_b, plan->share, result.candidates,
                 result.undecided, c->candidates, c->undecided);
}

// A's kernels are compiled apart from B's, which takes most of the time: where the two may differ
// and A is not alone, it searches in one way.
static void step_all_plans(check *c, duet_world *world)
{
    for (size_t w = 0; w < sizeof ways / sizeof *ways; ++w)
        for (int halves = 0; test_takes(w, 3) && halves < 2; ++halves) {
            if (c->def->shape == DUET_SHAPE_BOUNDS && strstr(ways[w].variant, "FUSED"))
                continue; // bounds need no test
            if (c->def->origin_edge > 0 && strcmp(ways[w].variant, "paper") == 0)
                continue; // which knows no origin cells
            duet_plan plan = {.mode = ways[w].mode};
            plan.share = halves ? DUET_SHARE_ONE / 2 : shares[w / 3 % 3];
            bool alike = plan.mode == DUET_MODE_SHARED || plan.share == DUET_SHARE_ONE;
            strcpy(plan.variant_a, alike ? ways[w].variant : "gpu");
            strcpy(plan.variant_b, ways[w].variant);
            step(c, world, &plan);
        }
}

static void count_pose_pair(check *c, const duet_bounds *bounds, uint32_t a, uint32_t b)
{
    const duet_world_def *def = c->def;
    double shift[3];
    origin_shift(shift, c->objects, def->origin_edge, a, b);
    if (!sat_bounds_overlap(&bounds[a], &bounds[b], shift, def->dims))
        return;
    ++c->candidates;
    const duet_pose *pose_a = origin_pose(c->objects, def->origin_edge, a);
    const duet_pose *pose_b = origin_pose(c->objects, def->origin_edge, b);
    c->undecided +=
        narrow_float_apart(pose_a, pose_b, shift, def->dims, def->rotated) == NARROW_UNDECIDED;
}

// Counts what the devices should count, by the arithmetic that they should do.
static void count_as_devices_do(check *c)
{
    if (c->def->shape == DUET_SHAPE_BOUNDS) {
        c->candidates = c->truth.n;
        return;
    }
    duet_bounds *bounds = malloc((c->n + 1) * sizeof *bounds);
    assert_non_null(bounds);
    for (uint32_t i = 0; i < c->n; ++i)
        bounds[i] = sat_bounds(origin_pose(c->objects, c->def->origin_edge, i), c->def->dims,
                               c->def->rotated);
    for (uint32_t a = 0; a < c->n; ++a)
        for (uint32_t b = a + 1; b < c->n; ++b)
            count_pose_pair(c, bounds, a, b);
    free(bounds);
}

static bool set_objects(duet_world *world, const duet_world_def *def, const void *objects,
                        uint32_t n, duet_error *err)
{
    if (def->origin_edge > 0)
        return duet_world_set_objects(world, DUET_OBJECT_LARGE_POSES, objects, n, err);
    return def->shape == DUET_SHAPE_POSES
               ? duet_world_set_objects(world, DUET_OBJECT_POSES, objects, n, err)
               : duet_world_set_objects(world, DUET_OBJECT_BOUNDS, objects, n, err);
}

uint64_t agreement_check(const duet_world_def *def, const void *objects, uint32_t n)
{
    bool poses = def->shape == DUET_SHAPE_POSES;
    reference_objects all = {
        .dims = def->dims,
        .shape = def->shape,
        .n = n,
        .poses = poses ? objects : NULL,
        .bounds = poses ? NULL : objects,
        .origin = def->origin_edge,
    };
    check c = {.def = def, .objects = objects, .n = n};
    c.truth =
        found_by(&all, n <= EACH_WITH_EACH_LIMIT ? REFERENCE_EACH_WITH_EACH : REFERENCE_COLUMNS);
    c.hash = duet_pairs_hash(c.truth.pairs, c.truth.n);
    count_as_devices_do(&c);
    duet_world *world = must(duet_world_create(def, ERR));
    must(set_objects(world, def, objects, n, ERR));
    step_all_plans(&c, world);
    duet_world_destroy(world);
    test_give_back(c.truth.pairs);
    return c.truth.n;
}
