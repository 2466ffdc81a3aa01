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
bool stack_stands(const stack *s, uint32_t seconds);
void stack_assert_stands(const stack *s, uint32_t seconds);

#endif
