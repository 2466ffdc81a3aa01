// SPDX-License-Identifier: MIT
// Ids of 64 bits that some of a world's objects have, whatever their places in its array.
#ifndef RUNTIME_GLOBAL_IDS_H
#define RUNTIME_GLOBAL_IDS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct global_ids {
    const uint64_t *list;    // [n] of the first n objects; those behind have none
    uint32_t n;              // pairs of two behind are nobody's here: they are left out
    const uint32_t *without; // [n_without] ascending: of the first n these have none either
    uint32_t n_without;
    const uint32_t *changed; // [n_changed] places, in any order, whose id is another than in the
    uint64_t n_changed;      // last step, or who had one and have none, or the other way round
    bool all_changed;
    uint64_t version, before; // the world's, now and in its last step
} global_ids;

#endif
