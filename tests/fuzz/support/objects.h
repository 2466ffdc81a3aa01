// SPDX-License-Identifier: MIT
// What must hold of objects that a reader took.
#ifndef TESTS_FUZZ_OBJECTS_H
#define TESTS_FUZZ_OBJECTS_H

#include "runtime/duet.h"

#include <stddef.h>
#include <stdint.h>

// Every number is finite, no half extent is negative, no corner is above its
// opposite, no rotation is zero.
void fuzz_require_objects(const duet_scene *scene);

// Both hold the same objects.
void fuzz_require_same(const duet_scene *a, const duet_scene *b);

// Reads a file of that name and content as objects, as they are and in origin cells.
void fuzz_read_objects(const char *name, const uint8_t *data, size_t n);

#endif
