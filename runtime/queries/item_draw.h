// SPDX-License-Identifier: MIT
// Items of a query by chance, in the extent of the objects that are asked.
#ifndef QUERIES_ITEM_DRAW_H
#define QUERIES_ITEM_DRAW_H

#include "runtime/queries/query_name.h"

typedef struct item_objects {
    const void *rows; // in their kind's form
    uint32_t n;       // 1 or more
    uint32_t dims;
    duet_shape shape;
    float origin_edge; // 0: they are in no origin cells
} item_objects;

// Draws n > 0 items for a query of that name, the same for the same seed; the caller frees them.
// NO_MEMORY.
void *item_draw(const query_name *name, uint64_t n, const item_objects *among, uint64_t seed,
                duet_error *err);

#endif
