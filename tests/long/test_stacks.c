// SPDX-License-Identifier: MIT
// Tall stacks for a minute, near and far; a pyramid and a house of cards.
#include "support/figure.h"
#include "support/stack.h"
#include "support/test.h"

TEST(tall_stacks_stand_for_a_minute)
{
    stack_figures f = stack_figures_read();
    for (int i = 0; i < 3; ++i)
        for (uint32_t dims = i < 2 ? 2 : 3; dims <= 3; ++dims) {
            stack s = {.dims = dims, .height = f.heights[i], .substeps = f.substeps[i]};
            stack_assert_stands(&s, f.seconds);
        }
}

TEST(a_higher_stack_falls)
{
    stack_figures f = stack_figures_read();
    stack s = {.dims = 3, .height = f.falling_height, .substeps = f.falling_substeps};
    assert_false(stack_stands(&s, f.seconds));
}

TEST(a_stack_stands_as_well_far_away)
{
    static const double places[] = {1e4, 1e6, 1e7};
    for (int i = 0; i < 3; ++i) {
        stack s = {.dims = 3, .height = 10, .substeps = 4, .x = places[i], .doubles = true};
        stack_assert_stands(&s, 60);
    }
}

TEST(a_pyramid_does_not_tremble)
{
    double f[3], fastest = 0.0;
    figures("effects.md", "pyramid of # rows, after # s | nothing is faster than # mm/s", 3, f);
    mover *m = mover_new(3);
    mover_add_pyramid(m, (uint32_t)f[0]);
    mover_run(m, (uint32_t)(60 * f[1]));
    for (int i = 0; i < 30; ++i) {
        mover_run(m, 10);
        fastest = fmax(fastest, mover_greatest_speed(m));
    }
    print_message("%g mm/s\n", 1e3 * fastest);
    assert_true(fastest < 1e-3 * f[2]);
}

TEST(a_house_of_cards_stands)
{
    double f[3];
    figures("effects.md", "house of # cards, 20 x 400 x 400 mm, # s | sinks by less than # mm", 3,
            f);
    mover *m = mover_new(3);
    mover_add_card_house(m, 5);
    assert_int_equal(m->n - 1, (int)f[0]);
    double height = m->poses[m->n - 1].centre[2];
    mover_run(m, (uint32_t)(60 * f[1]));
    double sunk = height - m->states[m->n - 1].centre[2];
    print_message("%g mm\n", 1e3 * sunk);
    assert_true(sunk < 1e-3 * f[2]);
}

TEST(a_great_pile_does_not_sleep_deep)
{
    double f[6];
    figures(
        "effects.md",
        "| # boxes of `falling.lua`, # s | all sleep, no contact is deeper than # slops, and of "
        "# points at most # is deeper than #",
        6, f);
    assert_close(f[0], 20000, 0.0);
    const double slop = 0.003; // nearly what it is by itself
    const duet_setting n = {"n", "20000"};
    duet_scene *scene = kept(duet_scene_load("falling", &n, 1, ERR));
    duet_motion_def def = duet_scene_motion_def(scene, default_pair());
    duet_motion *motion = kept(duet_motion_create_from_scene(&def, scene, NULL, ERR));
    duet_motion_result last = {0};
    for (int step = 0; step < 60 * f[1]; ++step)
        must(duet_motion_advance(motion, &last, ERR));
    assert_int_equal(last.contacts, 0);
    duet_contact *contacts = NULL;
    uint64_t n_contacts = 0;
    must(duet_motion_get_contacts(motion, &contacts, &n_contacts, ERR));
    assert_true(n_contacts > 2 * f[0]);
    double deepest = 0.0, n_points = 0.0, n_deep = 0.0;
    for (uint64_t i = 0; i < n_contacts; ++i)
        for (uint32_t k = 0; k < contacts[i].n; ++k) {
            double depth = -(double)contacts[i].points[k].separation;
            deepest = fmax(deepest, depth);
            n_points += 1.0;
            n_deep += depth > f[5] * slop;
        }
    print_message("%g slops, %g of %g points\n", deepest / slop, n_deep, n_points);
    assert_true(deepest < f[2] * slop);
    assert_true(f[3] * n_deep <= f[4] * n_points);
    free(contacts);
}
