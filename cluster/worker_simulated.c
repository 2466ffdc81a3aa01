// SPDX-License-Identifier: MIT
// In the place of a rank's work: it takes its time, and finds nothing.
#include "cluster/worker_host.h"

#include "base/error.h"
#include "cluster/ranks.h"

typedef struct simulated_worker {
    worker_host host;
    const simulation *simulation;
    const uint64_t *n_ghosts; // of the rank, whose parts divide them
    uint32_t n_parts;
    double object_seconds;
} simulated_worker;

static bool find(worker *w, worker_found *found, duet_error *err)
{
    const simulated_worker *p = (simulated_worker *)w;
    double n_ghosts = (double)*p->n_ghosts / p->n_parts;
    (void)err;
    p->simulation->pass(p->object_seconds *
                        (p->host.n + (p->simulation->ghost_objects - 1) * n_ghosts));
    *found = (worker_found){0};
    return true;
}

// Of ranks that were measured with others beside them, what that many cost. Else what a host does
// in a time is shared by the ranks that it has.
static double slowdown(const ranks *r)
{
    const simulation *s = r->simulation;
    if (s->company)
        return s->company[r->n_on_host - 1];
    return s->ranks_a_host > 0 ? r->n_on_host / s->ranks_a_host : 1;
}

static bool check_company(const ranks *r, duet_error *err)
{
    const simulation *s = r->simulation;
    return !s->company || (uint32_t)r->n_on_host <= s->n_company ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "the profile was measured with up to %u ranks on a host, and here are %d; "
                     "expected no more",
                     s->n_company, r->n_on_host);
}

worker *worker_open_simulated(const duet_world_def *def, const ranks *r, const uint64_t *n_ghosts,
                              uint32_t n_parts, duet_error *err)
{
    const simulation *s = r->simulation;
    if (!check_company(r, err))
        return NULL;
    simulated_worker *p = worker_host_open(sizeof *p, "simulated", def, err);
    if (!p)
        return NULL;
    p->host.base.find = find;
    p->simulation = s;
    p->n_ghosts = n_ghosts;
    p->n_parts = n_parts;
    p->object_seconds =
        s->object_seconds[(uint32_t)r->self % s->n_seconds] * slowdown(r) * s->stands_for;
    return &p->host.base;
}
