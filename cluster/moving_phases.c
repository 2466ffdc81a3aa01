// SPDX-License-Identifier: MIT
#include "cluster/moving_phases.h"

#include "cluster/moving_domains.h"

static phase_cost cost_so_far(const moving *m)
{
    const ranks *r = m->ranks;
    phase_cost c = {.ms = 1e-6 * (double)ranks_now_ns(),
                    .wait_ms = 1e-6 * (double)r->wait_ns,
                    .exchanges = r->n_waits,
                    .bytes = r->sent_bytes};
    for (uint32_t k = 0; k < m->parts; ++k) {
        const timeline *t = &m->domains[k].motion->times;
        c.launches += t->all_launches;
        c.waits += t->all_waits;
    }
    return c;
}

void moving_enter(moving *m, moving_phase phase)
{
    moving_phases *p = &m->phases;
    phase_cost now = cost_so_far(m), *to = &p->costs[p->now];
    to->ms += now.ms - p->begun.ms;
    to->wait_ms += now.wait_ms - p->begun.wait_ms;
    to->launches += now.launches - p->begun.launches;
    to->waits += now.waits - p->begun.waits;
    to->exchanges += now.exchanges - p->begun.exchanges;
    to->bytes += now.bytes - p->begun.bytes;
    p->begun = now;
    p->now = phase;
}

const char *moving_phase_name(moving_phase phase)
{
    static const char *const names[MOVING_PHASES] = {
        [PHASE_MANIFOLDS] = "manifolds", [PHASE_SLEEP] = "sleep",
        [PHASE_COLOURS] = "colours",     [PHASE_WAITING] = "waiting",
        [PHASE_CLOSURE] = "closure",     [PHASE_LISTS] = "lists",
        [PHASE_SUBSTEPS] = "substeps",   [PHASE_FINALIZE] = "finalize",
        [PHASE_LEAVE] = "leave",         [PHASE_TRAVEL] = "travel",
        [PHASE_REPLACE] = "replace",     [PHASE_SHARE] = "share",
    };
    return names[phase];
}
