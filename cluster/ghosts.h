// SPDX-License-Identifier: MIT
// Ghosts: objects of other domains that a domain's objects may touch, and whose pairs with them
// that domain finds. Exact whatever the objects' sizes: no width is chosen. Domains of one rank
// exchange ghosts as domains of several ranks do.
#ifndef CLUSTER_GHOSTS_H
#define CLUSTER_GHOSTS_H

#include "cluster/owned.h"

// A boundary object that is a ghost elsewhere.
typedef struct visit {
    uint32_t row;
    uint32_t from, to; // places
} visit;

typedef LIST_OF(visit, visits) visit_list;

// The ghosts of the last exchange, whose memory the next one uses.
typedef struct ghosts {
    parcels in; // the messages: an object's, and two places behind it
    parcels out;
    visit_list parts[PARALLEL_MOST];
    level_boxes *boxes; // [n of places]
    uint64_t *first;    // [n_domains + 1] of each domain's in list
    uint32_t *list;     // [in.n] messages, domain after domain; NULL: there is one domain
} ghosts;

bool ghosts_begin(ghosts *g, const owned *o, const ranks *r, duet_error *err);

// Sends ghosts to where they belong; `in` has the ghosts that came. Collective; fails on all ranks
// if one is not well.
bool ghosts_exchange(ghosts *g, const owned *o, ranks *r, duet_error *err);
void ghosts_end(ghosts *g);

// Lists the ghosts that came by their domains: domain d's ghosts are [first[d], first[d + 1]).
bool ghosts_sort(ghosts *g, const owned *o, const ranks *r, duet_error *err);

// Returns how many of them came from other ranks.
static inline uint64_t ghosts_of_others(const ghosts *g, const ranks *r)
{
    return g->in.counts ? g->in.n - g->in.counts[r->self] : 0;
}

typedef struct ghost {
    uint64_t id;
    const void *object;
    uint32_t from; // place
} ghost;

// Returns the i-th ghost in that order.
ghost ghosts_get(const ghosts *g, uint64_t i);

#endif
