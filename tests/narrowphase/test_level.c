// SPDX-License-Identifier: MIT
// Each level's promise on hard pairs.
#include "support/test.h"

#include "support/figure.h"
#include "support/hard_pairs.h"
#include "support/promise.h"

#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/sat_frame.h"

enum { PAIRS = 10000 }; // pairs of each of 22 classes

static bool promise_holds(duet_level l, const hard_pair *p, uint32_t dims)
{
    const duet_level_info *info = duet_level_get_info(l);
    bool answer = level_collide(l, &p->a, &p->b, narrow_here, dims, true);
    return promise_allows(info->missed, info->added, p, dims, answer);
}

TEST(each_level_keeps_its_promise_on_hard_pairs)
{
    rng r = rng_seed(test_seed());
    double said = figure("notes/accuracy.md", "every level keeps its promise on # generated pairs");
    int n = 0;
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < PAIRS; ++i) {
            uint32_t dims = i % 4 == 3 ? 2 : 3;
            hard_pair pair = c->make(&r, dims);
            ++n;
            for (int l = 0; l < DUET_LEVELS; ++l)
                if (!promise_holds((duet_level)l, &pair, dims)) {
                    hard_pair_print(&pair, dims);
                    fail_msg("%s on pair %d of '%s'", duet_level_get_info((duet_level)l)->name, i,
                             c->name);
                }
        }
    assert_int_equal(n, (int)said);
}

// To two digits, as they are printed.
static void assert_printed(double value, double printed)
{
    assert_true(fabs(value / printed - 1) < 0.04);
}

TEST(the_document_s_bounds_are_the_levels)
{
    double f[4];
    const duet_level_info *textbook = duet_level_get_info(DUET_LEVEL_SAT15);
    figures("accuracy.md",
            "only with a separation above -48 u S = # S | only with a separation up to # S", 2, f);
    figures("accuracy.md", "only with a separation above # S | only with a separation up to # S", 2,
            f + 2);
    assert_printed(-textbook->missed, f[0]);
    assert_printed(textbook->added, f[1]);
    const duet_level_info *in_double = duet_level_get_info(DUET_LEVEL_DOUBLE);
    assert_printed(-in_double->missed, f[2]);
    assert_printed(in_double->added, f[3]);
}

// Each level reports no less than a better one, but for rounding.
TEST(better_levels_report_fewer_random_pairs)
{
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
        print_message("%-10s %d of %d\n", duet_level_get_info((duet_level)l)->name, found[l], N);
    for (int i = 1; i < STEPS; ++i)
        assert_true(found[ladder[i]] <= found[ladder[i - 1]]);
    assert_true(found[DUET_LEVEL_SAT6] > found[DUET_LEVEL_CERTIFIED]);
    assert_true(found[DUET_LEVEL_SPHERE] > found[DUET_LEVEL_CERTIFIED]);
    assert_in_range(found[DUET_LEVEL_SAT15], found[DUET_LEVEL_CERTIFIED],
                    found[DUET_LEVEL_CERTIFIED] + 2);
    assert_int_equal(found[DUET_LEVEL_DOUBLE], found[DUET_LEVEL_CERTIFIED]);
}

// ------------------------------------------------------------ spheres

static long double length(const float v[3], float from[3])
{
    long double sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += ((long double)v[i] - from[i]) * ((long double)v[i] - from[i]);
    return sqrtl(sum);
}

// A half extent about as large as 2^power, or much smaller, or 0.
static float any_half(rng *r, int power)
{
    static const int smaller[] = {0, 0, 1, 12, 60};
    return rng_below(r, 6) == 0
               ? 0
               : ldexpf((float)rng_between(r, 0.5, 1), power - smaller[rng_below(r, 5)]);
}

// Two boxes whose spheres are within 2^-12 to 2^-22 of touching.
static hard_pair spheres_that_nearly_touch(rng *r, int power)
{
    static float origin[3];
    hard_pair p = {{{0}, {0}, {0, 0, 0, 1}}, {{0}, {0}, {0, 0, 0, 1}}};
    double way[3], norm = 0;
    for (int i = 0; i < 3; ++i) {
        p.a.half_extents[i] = any_half(r, power);
        p.b.half_extents[i] = any_half(r, power);
        way[i] = rng_below(r, 4) ? rng_normal(r) : 0;
        norm += way[i] * way[i];
    }
    double reach = (double)(length(p.a.half_extents, origin) + length(p.b.half_extents, origin));
    reach *= 1 + (rng_below(r, 2) ? 1 : -1) * pow(2, -rng_between(r, 12, 22));
    for (int i = 0; i < 3; ++i)
        p.b.centre[i] = norm > 0 ? (float)(way[i] / sqrt(norm) * reach) : 0;
    return p;
}

// Neither misses spheres that touch nor reports what is 2^-18 of its reach apart, for
// sizes from 2^-70 to 2^100.
TEST(spheres_are_told_apart_in_the_whole_range)
{
    static float origin[3];
    int n_apart = 0, n_near = 0;
    rng r = rng_seed(test_seed());
    double range[2]; // S, of which the test has a little less for its own rounding
    figures("accuracy.md", "not normalised; S as above, in #..#", 2, range);
    for (int i = 0; i < 400000; ++i) {
        hard_pair p = spheres_that_nearly_touch(&r, -74 + i % 176);
        double size = promise_size(&p, 3);
        bool collide = sat_spheres_overlap(&p.a, &p.b, narrow_here, 3);
        long double distance = length(p.b.centre, p.a.centre);
        long double reach = length(p.a.half_extents, origin) + length(p.b.half_extents, origin);
        bool known = size >= range[0] * 0x1.00001p0 && size <= range[1] * 0x1.fffffp-1;
        bool wrong = collide ? known && distance > reach * (1 + 0x1p-18L) : distance <= reach;
        if (wrong) {
            hard_pair_print(&p, 3);
            fail_msg("of size %a: %s, spheres %Lg apart and %Lg wide", size,
                     collide ? "reported" : "missed", distance, reach);
        }
        n_apart += !collide;
        n_near += distance > reach;
    }
    print_message("%d of %d told apart\n", n_apart, n_near);
    assert_true(n_apart > n_near / 4);
}

// A plate across axis k, as wide as anything.
static duet_pose plate_at(int k, float at)
{
    duet_pose plate = {{0}, {1e30f, 1e30f, 1e30f}, {0, 0, 0, 1}};
    plate.centre[k] = at;
    plate.half_extents[k] = 0;
    return plate;
}

TEST(bounds_contain_their_box)
{
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < 200; ++i) {
            uint32_t dims = 2 + (uint32_t)i % 2;
            duet_pose box = c->make(&r, dims).b;
            duet_bounds own = sat_bounds(&box, dims, true);
            for (uint32_t k = 0; k < dims; ++k) {
                duet_pose above = plate_at((int)k, nextafterf(own.upper[k], INFINITY));
                duet_pose below = plate_at((int)k, nextafterf(own.lower[k], -INFINITY));
                assert_false(narrow_decide(&box, &above, dims));
                assert_false(narrow_decide(&box, &below, dims));
            }
        }
}

TEST(names_name_levels)
{
    duet_level found;
    for (int l = 0; l < DUET_LEVELS; ++l) {
        assert_true(duet_level_from_name(duet_level_get_info((duet_level)l)->name, &found));
        assert_int_equal(found, l);
    }
    assert_false(duet_level_from_name("sat", &found));
    assert_null(duet_level_get_info(DUET_LEVELS));
}
