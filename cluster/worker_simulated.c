// SPDX-License-Identifier: MIT
// In the place of a rank's work: it takes its time, and finds nothing.
#include "cluster/worker_host.h"

#include "cluster/ranks.h"

typedef struct simulated_worker {
    worker_host host;
    const simulation *simulation;
    double object_seconds;
} simulated_worker;

static bool find(worker *w, worker_found *found, duet_error *err)
{
    const simulated_worker *p = (simulated_worker *)w;
    (void)err;
    p->simulation->pass(p->object_seconds * p->host.n);
    *found = (worker_found){0};
    return true;
}

// What a host does in a time is shared by the ranks that it has.
static double object_seconds(const ranks *r)
{
    const simulation *s = r->simulation;
    double share = s->ranks_a_host > 0 ? r->n_on_host / s->ranks_a_host : 1;
    return s->object_seconds[(uint32_t)r->self % s->n_seconds] * share * s->stands_for;
}

worker *worker_open_simulated(const duet_world_def *def, const ranks *r, duet_error *err)
{
    simulated_worker *p = worker_host_open(sizeof *p, "simulated", def, err);
    if (!p)
        return NULL;
    p->host.base.find = find;
    p->simulation = r->simulation;
    p->object_seconds = object_seconds(r);
    return &p->host.base;
}
