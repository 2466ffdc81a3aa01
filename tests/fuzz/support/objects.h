// SPDX-License-Identifier: MIT
// What must hold of objects that a reader took.
#ifndef TESTS_FUZZ_OBJECTS_H
#define TESTS_FUZZ_OBJECTS_H

#include "runtime/duet.h"

// Every number is finite, no half extent is negative, no corner is above its
// opposite, no rotation is zero.
void fuzz_require_objects(const duet_scene *scene);

// Both hold the same objects.
void fuzz_require_same(const duet_scene *a, const duet_scene *b);

#endif
