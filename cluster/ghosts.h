// SPDX-License-Identifier: MIT
// Ghosts: objects of other ranks that this rank's homes may touch, and whose pairs with them
// this rank finds. Exact whatever the objects' sizes: no width is chosen.
#ifndef CLUSTER_GHOSTS_H
#define CLUSTER_GHOSTS_H

#include "cluster/homes.h"

// A home that is a ghost elsewhere.
typedef struct visit {
    uint32_t home;
    uint32_t neighbour; // of those that the search knows
} visit;

typedef struct visits {
    visit *list;
    uint64_t n;
    uint64_t capacity;
} visits;

// Those of the last exchange, whose memory the next one uses.
typedef struct ghosts {
    parcels in; // messages of other ranks
    parcels out;
    visits parts[PARALLEL_MOST];
} ghosts;

// The messages that arrive become g->in. Collective; ok: whether this rank is well.
bool ghosts_exchange(ghosts *g, const homes *h, ranks *r, bool ok, duet_error *err);
void ghosts_end(ghosts *g);

#endif
