// SPDX-License-Identifier: MIT
// Global ids of 64 bits. A world's first n objects have them, but for those in `without`.
#ifndef RUNTIME_GLOBAL_IDS_H
#define RUNTIME_GLOBAL_IDS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct global_ids {
    const uint64_t *list;    // [n] by object; those behind have none
    uint32_t n;              // pairs of two objects without ids are left out
    const uint32_t *without; // [n_without] ascending: those of the first n that have none
    uint32_t n_without;
    const uint32_t *changed; // [n_changed] objects, in any order, whose id is not that of the
    uint64_t n_changed;      // last step: another, a first one, or none any more
    uint64_t generation;     // the world's for the list
} global_ids;

// All ids may be others.
#define ALL_IDS_CHANGED UINT64_MAX

#endif
