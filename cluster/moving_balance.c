// SPDX-License-Identifier: MIT
// Which rank has how much to do in a step, and how long it is busy with that.
#include "cluster/moving_domains.h"

#include "base/clock.h"
#include "base/error.h"

#include <stdlib.h>

// Ranks compare their times after so many steps.
enum { COMPARED_STEPS = 8 };

// Less than this part of the mean is no loss that a cut would end.
static const double least_loss = 0.02;

// A CPU's work takes its processors' time, whatever else they do; a GPU's takes what is no wait.
static uint64_t busy_ns(const moving *m)
{
    const ranks *r = m->ranks;
    bool is_cpu = m->domains[0].motion->device->info.kind == DUET_KIND_CPU;
    return is_cpu ? clock_process_ns() - r->spun_ns : ranks_now_ns() - r->wait_ns;
}

// Contacts have two ends, and few of them are others'.
static double ends_of(const moving_domain *d)
{
    return 2.0 * d->motion->solver.n_pushing;
}

static work_row row_of(moving *m)
{
    work_row row = {0};
    uint64_t now = busy_ns(m);
    for (uint32_t k = 0; k < m->parts; ++k) {
        row.bodies += m->domains[k].n_own;
        row.ends += ends_of(&m->domains[k]);
    }
    row.busy_ns = m->balance.since_ns > 0 ? (double)(now - m->balance.since_ns) : 0.0;
    m->balance.since_ns = now;
    return row;
}

void moving_note_work(moving *m, tally *t)
{
    const work_row row = row_of(m);
    work_row *done = &m->balance.done;
    const double work = work_of(&m->balance.model, row.bodies, row.ends);
    done->bodies += row.bodies;
    done->ends += row.ends;
    done->busy_ns += row.busy_ns;
    t->sums[1] = (uint64_t)(1e3 * work);
    t->sums[2] = (uint64_t)row.busy_ns;
    every_note_step(m, t);
    t->greatest[0] = work;
    t->greatest[1] = row.busy_ns;
}

static void learn(moving *m, const work_row *rows)
{
    const uint32_t n = (uint32_t)m->ranks->n;
    uint32_t slowest = 0;
    work_note(&m->balance.model, rows, n);
    for (uint32_t i = 1; i < n; ++i)
        slowest = rows[i].busy_ns > rows[slowest].busy_ns ? i : slowest;
    m->counts.slowest_rank = slowest;
    m->balance.done = (work_row){0};
    m->balance.steps = 0;
}

static bool compare_times(moving *m, duet_error *own)
{
    work_row *rows = calloc((size_t)m->ranks->n, sizeof *rows);
    if (!rows)
        no_memory(own, "%d ranks", m->ranks->n);
    bool ok = ranks_agree(m->ranks, is_well(own), own);
    if (ok) {
        ranks_gather(m->ranks, &m->balance.done, rows, sizeof *rows);
        learn(m, rows);
    }
    free(rows);
    return ok;
}

bool moving_compare_work(moving *m, const tally *t, duet_error *own)
{
    moving_balance *b = &m->balance;
    const double n = m->ranks->n;
    every_take_step(m, t);
    b->most = t->greatest[0];
    b->mean = 1e-3 * (double)t->sums[1] / n;
    m->counts.slowest_ms = 1e-6 * t->greatest[1];
    m->counts.mean_ms = 1e-6 * (double)t->sums[2] / n;
    if (b->most > (1.0 + least_loss) * b->mean)
        b->lost += b->most / b->mean - 1.0;
    return ++b->steps < COMPARED_STEPS || compare_times(m, own);
}
