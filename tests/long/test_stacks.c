// SPDX-License-Identifier: MIT
// Tall stacks for a minute, near and far.
#include "support/stack.h"
#include "support/test.h"

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

static void a_tall_stack_falls_with_too_few_substeps(void **state)
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tall_stacks_stand_for_a_minute),
        cmocka_unit_test(a_tall_stack_falls_with_too_few_substeps),
        cmocka_unit_test(a_stack_stands_as_well_far_away),
    };
    return cmocka_run_group_tests(tests, mover_open_pair, mover_close_pair);
}
