// SPDX-License-Identifier: MIT
// What a still scene decided of the kernels that find its pairs, and which of
// them its last step ran.
#ifndef RUNTIME_WORLD_EXPLAIN_H
#define RUNTIME_WORLD_EXPLAIN_H

#include "runtime/broadphase/world.h"

// A property of the scene that kernels have compiled in.
typedef struct world_fact {
    const char *name;      // "rotation"
    const char *parameter; // "ROTATED"
    int64_t value;
    const char *means; // says what is in the kernels for it, or left out
} world_fact;

// Side 0 is A, 1 is B. False past the last; a side that had no work has none.
bool world_fact_at(const duet_world *world, int side, uint32_t i, world_fact *fact);

typedef struct world_kernel {
    const char *name; // the name as it ran, with its parameters; or the kernel's alone
    bool runs;
    const char *why; // says what calls for it, or why it is left out
} world_kernel;

bool world_kernel_at(const duet_world *world, int side, uint32_t i, world_kernel *k);

#endif
