// SPDX-License-Identifier: MIT
// Each level's promise on hard pairs.
#include "support/test.h"

#include "support/hard_pairs.h"
#include "support/promise.h"

#include "runtime/level.h"
#include "runtime/meeting.h"
#include "runtime/narrow.h"

#include <math.h>

enum { PAIRS = 10000 }; // of each of 22 classes

static bool promise_holds(duet_level l, const hard_pair *p, uint32_t dims)
{
    const duet_level_info *info = duet_level_describe(l);
    bool answer = level_collide(l, &p->a, &p->b, narrow_here, dims, true);
    return promise_allows(info->missed, info->added, p, dims, answer);
}

static void each_level_keeps_its_promise_on_hard_pairs(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < PAIRS; ++i) {
            uint32_t dims = i % 4 == 3 ? 2 : 3;
            hard_pair pair = c->make(&r, dims);
            for (int l = 0; l < DUET_LEVELS; ++l)
                if (!promise_holds((duet_level)l, &pair, dims)) {
                    hard_pair_print(&pair, dims);
                    fail_msg("%s on pair %d of '%s'", duet_level_describe((duet_level)l)->name, i,
                             c->name);
                }
        }
}

static duet_pose random_box(rng *r, double spread)
{
    duet_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.centre[i] = (float)rng_between(r, 0, spread);
        pose.half[i] = (float)rng_between(r, 0.1, 1);
    }
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = (float)rng_normal(r);
    return pose;
}

// Each level reports no less than a better one, but for rounding.
static void better_levels_report_fewer_random_pairs(void **state)
{
    (void)state;
    static const duet_level ladder[] = {DUET_LEVEL_AABB, DUET_LEVEL_SAT6, DUET_LEVEL_SAT15,
                                        DUET_LEVEL_CERTIFIED};
    enum { N = 20000, STEPS = sizeof ladder / sizeof *ladder };
    rng r = rng_seed(test_seed());
    int found[DUET_LEVELS] = {0};
    for (int i = 0; i < N; ++i) {
        duet_pose a = random_box(&r, 3), b = random_box(&r, 3);
        for (int l = 0; l < DUET_LEVELS; ++l)
            found[l] += level_collide((duet_level)l, &a, &b, narrow_here, 3, true);
    }
    for (int l = 0; l < DUET_LEVELS; ++l)
        print_message("%-10s %d of %d\n", duet_level_describe((duet_level)l)->name, found[l], N);
    for (int i = 1; i < STEPS; ++i)
        assert_true(found[ladder[i]] <= found[ladder[i - 1]]);
    assert_true(found[DUET_LEVEL_SAT6] > found[DUET_LEVEL_CERTIFIED]);
    assert_true(found[DUET_LEVEL_SPHERE] > found[DUET_LEVEL_CERTIFIED]);
    assert_in_range(found[DUET_LEVEL_SAT15], found[DUET_LEVEL_CERTIFIED],
                    found[DUET_LEVEL_CERTIFIED] + 2);
    assert_int_equal(found[DUET_LEVEL_DOUBLE], found[DUET_LEVEL_CERTIFIED]);
}

// A plate across axis k, as wide as anything.
static duet_pose plate_at(int k, float at)
{
    duet_pose plate = {{0}, {1e30f, 1e30f, 1e30f}, {0, 0, 0, 1}};
    plate.centre[k] = at;
    plate.half[k] = 0;
    return plate;
}

static void bounds_contain_their_box(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < 200; ++i) {
            uint32_t dims = 2 + (uint32_t)i % 2;
            duet_pose box = c->make(&r, dims).b;
            duet_bounds own = meeting_bounds(&box, dims, true);
            for (uint32_t k = 0; k < dims; ++k) {
                duet_pose above = plate_at((int)k, nextafterf(own.upper[k], INFINITY));
                duet_pose below = plate_at((int)k, nextafterf(own.lower[k], -INFINITY));
                assert_false(narrow_decide(&box, &above, dims));
                assert_false(narrow_decide(&box, &below, dims));
            }
        }
}

static void names_name_levels(void **state)
{
    (void)state;
    duet_level found;
    for (int l = 0; l < DUET_LEVELS; ++l) {
        assert_true(duet_level_named(duet_level_describe((duet_level)l)->name, &found));
        assert_int_equal(found, l);
    }
    assert_false(duet_level_named("sat", &found));
    assert_null(duet_level_describe(DUET_LEVELS));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_level_keeps_its_promise_on_hard_pairs),
        cmocka_unit_test(better_levels_report_fewer_random_pairs),
        cmocka_unit_test(bounds_contain_their_box),
        cmocka_unit_test(names_name_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
