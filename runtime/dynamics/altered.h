// SPDX-License-Identifier: MIT
// Bodies that commands altered since pairs were made: those that came, went, or touch others than
// before. Within a skin the pairs of all other bodies hold on, and only those of the altered bodies
// are searched, by a hash table of them.
#ifndef RUNTIME_ALTERED_H
#define RUNTIME_ALTERED_H

#include "runtime/duet.h"

#include <CL/cl.h>

// If n is above 0, pairs are forgotten and bounds are not. With pairs and bounds forgotten, all
// bodies count as altered, and none is listed.
typedef struct altered_bodies {
    uint32_t *places;
    cl_uint n, capacity;
    // the table's
    cl_uint n_heads, pair_capacity;
    cl_float per_edge;
} altered_bodies;

static inline void altered_forget(altered_bodies *a)
{
    a->n = 0;
}

// Rows are to be searched about these places, or as a whole if that is no more work.
void motion_alter_places(duet_motion *m, const uint32_t *places, uint32_t n);
void motion_alter_all(duet_motion *m);

// In a step: makes the listed bodies' bounds, and the table of them.
bool motion_bound_altered(duet_motion *m, duet_error *err);

// Writes their pairs, and those of before that are of no listed body, into PAIRS. If n is above
// pair_capacity they had no space.
bool motion_search_altered(duet_motion *m, cl_uint *n, duet_error *err);

#endif
