// SPDX-License-Identifier: MIT
// The bound of the float test, attacked: a search changes boxes so that the
// error of their separation grows.
#include "support/figure.h"
#include "support/test.h"

#include "support/hard_pairs.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/sat_frame.h"

enum { CLIMBS = 200, STEPS = 10000 };

static float separation_in_float(const sat_frame *m)
{
    float separation = sat_frame_face_separation(m);
    for (int i = 0; m->dims == 3 && i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            separation = fmaxf(separation, sat_frame_edge_separation(m, i, j));
    return separation;
}

// The error of the greatest separation in units of 2^-24 S, of which the bound allows
// NARROW_SLACK.
static double error_of(const hard_pair *p, uint32_t dims)
{
    if (!narrow_is_box(&p->a, dims) || !narrow_is_box(&p->b, dims))
        return 0;
    sat_frame m = sat_frame_of(&p->a, &p->b, narrow_here, dims);
    if (!m.trusted)
        return 0;
    return fabs(separation_in_float(&m) -
                narrow_separation_apart(&p->a, &p->b, narrow_here, dims)) /
           (0x1p-24 * m.size);
}

// Some number of the pair becomes a little or quite another one.
static void change(hard_pair *p, rng *r)
{
    duet_pose *pose = rng_below(r, 2) ? &p->a : &p->b;
    uint32_t which = rng_below(r, 10);
    float *number = which < 3   ? &pose->centre[which]
                    : which < 6 ? &pose->half_extents[which - 3]
                                : &pose->rotation[which - 6];
    double by = rng_normal(r) * pow(2, -rng_between(r, 0, 24));
    *number = (float)(*number * (1 + by) + (rng_below(r, 8) ? 0 : by));
    for (int i = 0; i < 3; ++i)
        pose->half_extents[i] = fabsf(pose->half_extents[i]);
}

static double climb(hard_pair p, rng *r, uint32_t dims)
{
    double worst = error_of(&p, dims);
    for (int step = 0; step < STEPS; ++step) {
        hard_pair next = p;
        change(&next, r);
        double error = error_of(&next, dims);
        if (error >= worst) {
            worst = error;
            p = next;
        }
    }
    if (worst > NARROW_SLACK)
        hard_pair_print(&p, dims);
    return worst;
}

TEST(errors_that_a_search_drives_up_stay_below_the_bound)
{
    rng r = rng_seed(test_seed());
    double worst = 0;
    for (int i = 0; i < CLIMBS; ++i) {
        uint32_t dims = i % 4 == 3 ? 2 : 3;
        worst = fmax(worst, climb(hard_classes[0].make(&r, dims), &r, dims));
    }
    print_message("greatest error found: %.1f of %d\n", worst, NARROW_SLACK);
    assert_true(worst < NARROW_SLACK);
    double most =
        figure("notes/accuracy.md", "It prints how far it came: below # % of what the bound");
    assert_true(worst < most / 100 * NARROW_SLACK);
    assert_true(worst > 1); // else the search seeks nothing
}
