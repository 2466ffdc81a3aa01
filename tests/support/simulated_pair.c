// SPDX-License-Identifier: MIT
#include "support/simulated_pair.h"

#include <math.h>

#define WHOLE_NS 1e7 // B's time for the whole work

// A device's time for a part of the work, by its own time for all of it.
static double time_of_part(const simulated_pair *model, int device, double part)
{
    uint32_t waves = model->waves[device];
    double stepped = waves ? ceil(part * waves) / waves : part;
    return part > 0 ? model->fixed[device] + (1 - model->fixed[device]) * stepped : 0;
}

static void invent(const simulated_pair *model, uint32_t share, double ns[2])
{
    double part = share / (double)SEARCH_ONE;
    bool both = share > 0 && share < SEARCH_ONE;
    ns[0] = model->ratio * time_of_part(model, 0, part);
    ns[1] = time_of_part(model, 1, 1 - part);
    for (int device = 0; device < 2; ++device) {
        if (both)
            ns[device] = ns[device] * (1 + model->interference) + model->overhead[device];
        ns[device] *= WHOLE_NS;
    }
}

simulated_pair simulated_invent(simulated_family family, bool mirrored, rng *r)
{
    simulated_pair model = {.ratio = pow(family == SIMULATED_FIXED ? 4 : 64, rng_unit(r))};
    if (mirrored)
        model.ratio = 1 / model.ratio;
    double best = model.ratio / (model.ratio + 1);
    model.overhead[0] = best * rng_between(r, 0, 0.15);
    model.overhead[1] = best * rng_between(r, 0, 0.15);
    if (family == SIMULATED_STEPS) {
        model.waves[0] = 16 + rng_below(r, 49);
        model.waves[1] = 8 + rng_below(r, 25);
    } else if (family == SIMULATED_INTERF) {
        model.interference = rng_between(r, 0, 0.25);
    } else if (family == SIMULATED_FIXED) {
        model.fixed[0] = rng_between(r, 0.2, 0.6);
        model.fixed[1] = rng_between(r, 0.2, 0.6);
    }
    return model;
}

static double between(uint64_t from, uint64_t to, double part)
{
    return (double)from + part * ((double)to - (double)from);
}

static void look_up(const simulated_pair *model, uint32_t share, double ns[2])
{
    const simulated_row *rows = model->rows;
    uint32_t i = 1;
    while (i + 1 < model->n_rows && rows[i].share < share)
        ++i;
    double part = ((double)share - rows[i - 1].share) / (rows[i].share - rows[i - 1].share);
    ns[0] = between(rows[i - 1].a_ns, rows[i].a_ns, part);
    ns[1] = between(rows[i - 1].b_ns, rows[i].b_ns, part);
}

static double disturbed(const simulated_pair *model, double ns, rng *r)
{
    double factor = 1 + model->sigma * rng_normal(r);
    if (factor < 0.5)
        factor = 0.5;
    if (rng_unit(r) < model->spike_chance)
        factor *= rng_between(r, 1.2, model->spike_most);
    return ns * factor;
}

search_sample simulated_launch(const simulated_pair *model, uint32_t share, rng *r)
{
    double ns[2];
    if (model->rows)
        look_up(model, share, ns);
    else
        invent(model, share, ns);
    for (int device = 0; device < 2 && r; ++device)
        ns[device] = disturbed(model, ns[device], r);
    return (search_sample){
        .share = share,
        .total_ns = (uint64_t)(fmax(ns[0], ns[1]) + 0.5),
        .a_ns = (uint64_t)(ns[0] + 0.5),
        .b_ns = (uint64_t)(ns[1] + 0.5),
    };
}

search_sample simulated_best(const simulated_pair *model)
{
    search_sample best = simulated_launch(model, 0, NULL);
    for (uint32_t share = 1; share <= SEARCH_ONE; ++share) {
        search_sample at = simulated_launch(model, share, NULL);
        if (at.total_ns < best.total_ns)
            best = at;
    }
    return best;
}

bool simulated_run(search *s, const simulated_pair *model, rng *r, uint64_t *cost_ns,
                   duet_error *err)
{
    uint64_t cost = 0;
    bool ok = true;
    for (search_next next; (ok = search_ask(s, &next, err)) && !next.done;) {
        search_sample sample = simulated_launch(model, next.at.share, r);
        cost += sample.total_ns;
        ok = search_tell(s, &sample, err);
        if (!ok)
            break;
    }
    if (cost_ns)
        *cost_ns = cost;
    return ok;
}

double simulated_excess(const simulated_pair *model, uint32_t share)
{
    double best = (double)simulated_best(model).total_ns;
    return (double)simulated_launch(model, share, NULL).total_ns / best - 1;
}
