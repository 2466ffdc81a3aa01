// SPDX-License-Identifier: MIT
// Takes the time of a rank's search in a simulation, and finds nothing.
#include "cluster/worker_host.h"

#include "cluster/ranks.h"

typedef struct simulated_worker {
    worker_host host;
    const simulation *simulation;
} simulated_worker;

static bool find(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    const simulated_worker *p = (simulated_worker *)w;
    const simulation *s = p->simulation;
    (void)ids, (void)err;
    s->pass(s->object_seconds * s->stands_for * p->host.n);
    *found = (worker_found){0};
    return true;
}

worker *worker_open_simulated(const duet_world_def *def, const simulation *s, duet_error *err)
{
    simulated_worker *p = worker_host_open(sizeof *p, "simulated", def, err);
    if (!p)
        return NULL;
    p->host.base.find = find;
    p->simulation = s;
    return &p->host.base;
}
