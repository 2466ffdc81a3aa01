// SPDX-License-Identifier: MIT
// Unit boxes on each other: the taller, the more substeps they want
// (docs/effects.md).
#ifndef TESTS_STACK_H
#define TESTS_STACK_H

#include "support/mover.h"

typedef struct stack {
    uint32_t dims;
    uint32_t height; // boxes
    uint32_t substeps;
    double x; // how far away
    bool doubles;
} stack;

// Whether all boxes are in their places, at rest, after so many seconds; else
// the first that is not is printed.
// The stacks of docs/effects.md: heights with the substeps that they need, for
// so many seconds, how far their boxes may sway in parts of the height, and one that falls.
typedef struct stack_figures {
    uint32_t heights[3], substeps[3], seconds;
    double sway;
    uint32_t falling_height, falling_substeps;
} stack_figures;

stack_figures stack_figures_read(void);

bool stack_stands(const stack *s, uint32_t seconds);
void stack_assert_stands(const stack *s, uint32_t seconds);

#endif
