// SPDX-License-Identifier: MIT
// Tall stacks for a minute, near and far; a pyramid and a house of cards.
#include "support/figure.h"
#include "support/stack.h"
#include "support/test.h"

#include <math.h>

static void tall_stacks_stand_for_a_minute(void **state)
{
    (void)state;
    stack_figures f = stack_figures_read();
    for (int i = 0; i < 3; ++i)
        for (uint32_t dims = i < 2 ? 2 : 3; dims <= 3; ++dims) {
            stack s = {.dims = dims, .height = f.heights[i], .substeps = f.substeps[i]};
            stack_assert_stands(&s, f.seconds);
        }
}

static void a_higher_stack_falls(void **state)
{
    (void)state;
    stack_figures f = stack_figures_read();
    stack s = {.dims = 3, .height = f.falling_height, .substeps = f.falling_substeps};
    assert_false(stack_stands(&s, f.seconds));
}

static void a_stack_stands_as_well_far_away(void **state)
{
    (void)state;
    static const double places[] = {1e4, 1e6, 1e7};
    for (int i = 0; i < 3; ++i) {
        stack s = {.dims = 3, .height = 10, .substeps = 4, .x = places[i], .doubles = true};
        stack_assert_stands(&s, 60);
    }
}

static void a_pyramid_does_not_tremble(void **state)
{
    (void)state;
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
    mover_free(m);
}

static void a_house_of_cards_stands(void **state)
{
    (void)state;
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
    mover_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tall_stacks_stand_for_a_minute),
        cmocka_unit_test(a_higher_stack_falls),
        cmocka_unit_test(a_stack_stands_as_well_far_away),
        cmocka_unit_test(a_pyramid_does_not_tremble),
        cmocka_unit_test(a_house_of_cards_stands),
    };
    return cmocka_run_group_tests(tests, mover_open_pair, mover_close_pair);
}
