// SPDX-License-Identifier: MIT
// Tall stacks for a minute, near and far.
#include "support/stack.h"
#include "support/test.h"

static void tall_stacks_stand_for_a_minute(void **state)
{
    (void)state;
    static const stack stacks[] = {
        {.dims = 3, .height = 10, .substeps = 4},
        {.dims = 2, .height = 10, .substeps = 4},
        {.dims = 3, .height = 20, .substeps = 8},
        {.dims = 3, .height = 40, .substeps = 12},
        {.dims = 2, .height = 20, .substeps = 8},
    };
    for (size_t i = 0; i < sizeof stacks / sizeof stacks[0]; ++i)
        stack_assert_stands(&stacks[i], 60);
}

static void forty_boxes_fall_with_too_few_substeps(void **state)
{
    (void)state;
    stack s = {.dims = 3, .height = 40, .substeps = 8};
    assert_false(stack_stands(&s, 60));
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
        cmocka_unit_test(forty_boxes_fall_with_too_few_substeps),
        cmocka_unit_test(a_stack_stands_as_well_far_away),
    };
    return cmocka_run_group_tests(tests, mover_open_pair, mover_close_pair);
}
