// SPDX-License-Identifier: MIT
// Scenes drawn at random over all magnitudes that floats have, sizes and places
// apart from each other: whatever the scale, every plan finds the pairs and the
// candidates that the specification in C finds. DUET_TEST_ROUNDS says how many.
#include "support/test.h"

#include "support/agreement.h"
#include "support/devices.h"

enum { MOST = 300, ROUNDS = 300 };

// How a scene is drawn: about `centre`, as far as 2^reach, in steps of 2^step or
// anywhere, and sizes from 2^least to 2^most.
typedef struct drawing {
    double centre[3];
    int reach, step;
    bool steps;
    int least, most;
    double points; // how many have no size along an axis
} drawing;

static int between(rng *r, int least, int most)
{
    return least + (int)rng_below(r, (uint32_t)(most - least + 1));
}

static drawing draw(rng *r)
{
    drawing d = {.reach = between(r, -140, 120), .steps = rng_below(r, 2)};
    int above = between(r, -4, 30);
    for (int k = 0; k < 3; ++k) {
        double far = ldexp(rng_between(r, -1, 1), d.reach + above > 120 ? 120 : d.reach + above);
        d.centre[k] = rng_below(r, 3) ? far : 0;
    }
    d.step = d.reach - between(r, 2, 8);
    d.most = d.reach - between(r, 0, 7);
    d.least = d.most - between(r, 0, rng_below(r, 2) ? 3 : 24);
    d.points = rng_below(r, 3) ? 0 : 0.3;
    return d;
}

static float place(const drawing *d, int axis, rng *r)
{
    double at = ldexp(rng_between(r, -1, 1), d->reach);
    if (d->steps)
        at = ldexp(rint(ldexp(at, -d->step)), d->step);
    return (float)(d->centre[axis] + at);
}

static float size(const drawing *d, rng *r)
{
    if (rng_between(r, 0, 1) < d->points)
        return 0;
    double exact = d->steps ? ldexp(1, between(r, d->least, d->most))
                            : exp2(rng_between(r, d->least, d->most));
    return (float)exact;
}

static void draw_pose(duet_pose *pose, const drawing *d, bool rotated, rng *r)
{
    *pose = (duet_pose){.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        pose->centre[k] = place(d, k, r);
        pose->half_extents[k] = size(d, r);
    }
    for (int k = 0; rotated && k < 4; ++k)
        pose->rotation[k] = (float)rng_normal(r);
}

static void draw_bounds(duet_bounds *b, const drawing *d, rng *r)
{
    for (int k = 0; k < 3; ++k) {
        b->lower[k] = place(d, k, r);
        b->upper[k] = b->lower[k] + size(d, r);
    }
}

// Part of the scene, or far from it.
static void give_world(duet_world_def *def, const drawing *d, rng *r)
{
    def->has_world = true;
    for (int k = 0; k < 3; ++k) {
        def->lower[k] = place(d, k, r);
        def->upper[k] = def->lower[k] + (float)ldexp(rng_between(r, 0, 1), d->reach);
    }
}

TEST(scenes_of_any_scale_are_found_whole)
{
    const char *asked = getenv("DUET_TEST_ROUNDS");
    int rounds = asked ? atoi(asked) : ROUNDS;
    rng r = rng_seed(test_seed());
    uint64_t pairs = 0;
    for (int round = 0; round < rounds; ++round) {
        drawing d = draw(&r);
        duet_world_def def = devices_def(rng_below(&r, 2) ? 3 : 2);
        def.shape = rng_below(&r, 2) ? DUET_SHAPE_POSES : DUET_SHAPE_BOUNDS;
        def.rotated = rng_below(&r, 2);
        if (rng_below(&r, 3) == 0)
            give_world(&def, &d, &r);
        if (rng_below(&r, 4) == 0)
            def.cell = (float)ldexp(1, d.most > 120 ? 120 : d.most);
        uint32_t n = 1 + rng_below(&r, MOST);
        duet_pose poses[MOST];
        duet_bounds bounds[MOST];
        for (uint32_t i = 0; i < n; ++i) {
            draw_pose(&poses[i], &d, def.rotated, &r);
            draw_bounds(&bounds[i], &d, &r);
        }
        if (round % 20 == 0)
            print_message("round %d: reach 2^%d, sizes 2^%d to 2^%d, %u objects\n", round, d.reach,
                          d.least, d.most, n);
        pairs +=
            agreement_check(&def, def.shape == DUET_SHAPE_POSES ? (const void *)poses : bounds, n);
    }
    print_message("%llu pairs\n", (unsigned long long)pairs);
    assert_true(pairs > 0);
}
