// SPDX-License-Identifier: MIT
// The world is divided anew once ranks' work is unequal: borders that the scene's beginning gave do
// not suit what has fallen or spread since.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/parcels.h"

// So many points make a box off by a few in a hundred at most; a new cut pays for itself over
// steps.
enum { SAMPLE_A_DOMAIN = 1 << 13, LEAST_STEPS = 16, FEW_BODIES = 16 };

// Far more work than the mean is not waited with. Else as much must be lost as a cut and the
// exchange after it take, which is less than a step.
static const double most_imbalance = 1.2, price_steps = 1.0;

bool moving_cut_is_due(const moving *m)
{
    const moving_balance *b = &m->balance;
    return m->n_domains > 1 && m->counts.step >= m->next_cut &&
           (b->most > most_imbalance * b->mean + FEW_BODIES || b->lost > price_steps);
}

uint32_t moving_domain_of(const moving *m, const char *state)
{
    double at[3];
    domain_centre(m->domains[0].motion, state, at);
    return bisection_part(&m->cuts, at);
}

uint64_t moving_sampled(uint64_t n)
{
    return 1 + n / SAMPLE_A_DOMAIN;
}

// Own bodies, evenly over them.
static void choose_sampled(const moving_domain *d, uint64_t every, row_list *places)
{
    uint64_t n = 0;
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        if (moving_is_own(d, &d->bodies.rows[i]) && n++ % every == 0)
            row_list_add(places, (uint32_t)i);
}

// Their colours and states.
typedef struct sampled {
    uint32_t *used;
    char *states;
} sampled;

static bool read_sampled(const moving *m, const moving_domain *d, const row_list *places,
                         sampled *s, duet_error *own)
{
    const uint32_t n = (uint32_t)places->n;
    s->used = calloc(places->n + 1, sizeof *s->used);
    s->states = malloc(places->n * domain_state_bytes(d->motion) + 1);
    if (!s->used || !s->states || places->failed)
        return no_memory(own, "a partition");
    return domain_read_states(d->motion, places->rows, n, s->states, own) &&
           (!moving_pushes(m) || domain_read_used(d->motion, places->rows, n, s->used, own));
}

// Their centres; each stands for the work of as many.
static void sample(const moving *m, const moving_domain *d, item_list *points, duet_error *own)
{
    const uint64_t every = moving_sampled(d->n_own);
    const size_t state = domain_state_bytes(d->motion);
    row_list places = {0};
    sampled s = {0};
    choose_sampled(d, every, &places);
    bool ok = read_sampled(m, d, &places, &s, own);
    for (uint64_t i = 0; ok && i < places.n; ++i) {
        const uint32_t ends = (uint32_t)__builtin_popcount(s.used[i]);
        bisection_point point = {.weight = (double)every * work_of(&m->balance.model, 1, ends)};
        domain_centre(d->motion, s.states + i * state, point.at);
        list_add(points, &point, 1, sizeof point);
    }
    free(places.rows);
    free(s.used);
    free(s.states);
}

// Rank 0 cuts, so that all ranks have the same planes even if their machines round in different
// ways.
bool moving_cut_by(moving *m, const item_list *points, duet_error *own)
{
    const parcels_def out = {
        .n = points->n, .row_bytes = sizeof(bisection_point), .rows = points->items};
    parcels in = {0};
    if (is_well(own) && points->failed)
        no_memory(own, "a partition");
    bool ok = parcels_deal(m->ranks, is_well(own), &out, &in, own);
    if (ok && m->ranks->self == 0)
        bisection_cut(&m->cuts, NULL, in.rows, in.n);
    if (ok)
        ranks_broadcast(m->ranks, m->cuts.planes, m->n_domains * sizeof *m->cuts.planes);
    parcels_end(&in);
    return ok;
}

bool moving_cut(moving *m, const moving_domain *domains, uint32_t n, duet_error *own)
{
    item_list points = {0};
    for (uint32_t k = 0; is_well(own) && k < n; ++k)
        sample(m, &domains[k], &points, own);
    bool ok = moving_cut_by(m, &points, own);
    m->next_cut = m->counts.step + LEAST_STEPS;
    m->balance.lost = 0.0;
    free(points.items);
    return ok;
}
