// SPDX-License-Identifier: MIT
#include "cluster/ghost_traffic.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

const ghost_traffic ghost_traffics[GHOST_TRAFFICS] = {{1, 14, 1.71, 194, 0.42},
                                                      {2, 7, 3.55, 248, 0.55},
                                                      {4, 4, 8.73, 350, 0.79},
                                                      {8, 2, 13.7, 512, 1.11},
                                                      {31, 1, 37.8, 461, 1.36}};

const ghost_traffic *ghost_traffic_of(uint32_t colours)
{
    const ghost_traffic *found = ghost_traffics;
    for (uint32_t i = 1; i < GHOST_TRAFFICS; ++i)
        if (ghost_traffics[i].colours <= colours)
            found = &ghost_traffics[i];
    return found;
}

// Four substeps of two sweeps, and what the first one begins with. At the end of a step ghosts are
// told colours, ask for theirs, and come as a whole; ranks agree now and then.
enum { SWEEPS = 4 * 2, END_MESSAGES = 3, AGREEMENTS = 5 };

static uint64_t at_border(const ghosts *g, const ranks *r, int q)
{
    return q == r->self ? 0 : g->out.counts[q] + g->in.counts[q];
}

// Rows of a byte each, as many for each rank.
static bool reserve(parcels *p, const ghosts *g, const ranks *r, double bytes, duet_error *err)
{
    if (!parcels_begin(p, r, 1, err))
        return false;
    for (int q = 0; q < r->n; ++q)
        p->counts[q] = (uint64_t)ceil(bytes * (double)at_border(g, r, q));
    return parcels_reserve(p, r, NULL, err);
}

// Both sides send as much.
static bool pass(const ghosts *g, ranks *r, double bytes, uint32_t times, MPI_Request *requests,
                 duet_error *err)
{
    parcels out = {0}, in = {0};
    bool ok = is_well(err) && reserve(&out, g, r, bytes, err) && reserve(&in, g, r, bytes, err);
    ok = ranks_agree(r, ok, err);
    for (uint32_t i = 0; ok && i < times; ++i)
        parcels_pass(r, &out, &in, requests);
    parcels_end(&out);
    parcels_end(&in);
    return ok;
}

static void work(const ghost_traffic *t, const ghosts *g, const ranks *r, uint64_t n)
{
    uint64_t border = 0;
    for (int q = 0; q < r->n; ++q)
        border += at_border(g, r, q);
    r->simulation->pass(r->simulation->object_seconds * r->stands_for *
                        ((double)n + t->work * (double)border));
}

bool ghost_traffic_take(const ghost_traffic *t, const ghosts *g, ranks *r, uint64_t n,
                        duet_error *err)
{
    MPI_Request *requests = malloc(4 * (size_t)r->n * sizeof *requests);
    if (!requests)
        error_set(err, DUET_STATUS_NO_MEMORY, "messages to %d ranks: no memory", r->n);
    work(t, g, r, n);
    bool ok = pass(g, r, t->exchange_bytes, SWEEPS * t->exchanges + 1, requests, err) &&
              pass(g, r, t->step_bytes / END_MESSAGES, END_MESSAGES, requests, err);
    for (int i = 0; ok && i < AGREEMENTS; ++i)
        ok = ranks_agree(r, true, err);
    free(requests);
    return ok;
}
