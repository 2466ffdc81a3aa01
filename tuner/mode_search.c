// SPDX-License-Identifier: MIT
#include "tuner/joint_space.h"
#include "tuner/stages.h"
#include "tuner/strategy.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <string.h>

// A's time for all the work, from the least and the largest part that it did.
static double expect_a_alone(const search *h)
{
    const search_sample *small = NULL, *large = NULL;
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        if (at->a_ns == 0)
            continue;
        if (!small || at->share < small->share)
            small = at;
        if (!large || at->share > large->share)
            large = at;
    }
    if (!large)
        return INFINITY;
    if (large->share == small->share)
        return (double)large->a_ns * DUET_SHARE_ONE / large->share;
    double slope = ((double)large->a_ns - (double)small->a_ns) / (large->share - small->share);
    return (double)large->a_ns + fmax(slope, 0) * (DUET_SHARE_ONE - large->share);
}

bool mode_search_ask(tuning *t, search *s)
{
    const bool joint = s->strategy->choice != STRATEGY_SHARE;
    bool usable = true;
    while (usable || joint) {
        search_next next;
        duet_plan plan;
        trial got = {0};
        if (!search_ask(s, &next, &t->why))
            break;
        t->cut |= !next.done && !tuning_goes_on(t);
        if (next.done || t->cut)
            break;
        if (joint_space_plan(s->space, &next.at, &plan))
            got = tuning_run_trial(t, &plan);
        usable = got.usable;
        search_sample told = got.sample;
        told.share = next.at.share;
        told.failed = !usable;
        memcpy(told.configs, next.at.configs, sizeof told.configs);
        if ((usable || joint) && !search_tell(s, &told, &t->why))
            break;
    }
    return usable;
}

// near: a share to begin from; 0: none is known.
static mode_found search_mode(tuning *t, duet_mode mode, uint32_t near)
{
    search s;
    const joint_space share_alone = {.base = tuning_plan(t, 0, mode)};
    search_options options = search_default_options();
    options.quantum = t->problem->least_share;
    options.start = near;
    mode_found found = {.mode = mode, .a_alone_ns = INFINITY, .b_alone_ns = INFINITY};
    if (!search_begin(&s, t->problem->def->strategy, &options, &t->why))
        return found;
    s.script = t->problem->script;
    s.space = &share_alone;
    found.usable = mode_search_ask(t, &s) && s.n > 0;
    found.share = search_pick(&s);
    // One device alone may only seem the best if the search was cut short.
    if (t->cut && (found.share == 0 || found.share == DUET_SHARE_ONE))
        found.share = search_first_share(&s);
    found.a_alone_ns = expect_a_alone(&s);
    const search_sample *b_alone = search_at(&s, 0);
    if (b_alone)
        found.b_alone_ns = (double)b_alone->total_ns;
    search_end(&s);
    return found;
}

// One device's grid is of no use to the other if they search differently.
static bool mode_fits(const duet_plan *plan, duet_mode mode)
{
    size_t a = strcspn(plan->variant_a, " "), b = strcspn(plan->variant_b, " ");
    return mode == DUET_MODE_OWN || mode == DUET_MODE_SLAB ||
           (mode == DUET_MODE_SHARED && a == b &&
            strncmp(plan->variant_a, plan->variant_b, a) == 0);
}

static uint32_t list_modes(const tuning *t, duet_mode modes[MOST_MODES])
{
    const duet_tune_def *def = t->problem->def;
    uint32_t n = 0;
    for (uint32_t i = 0; n < MOST_MODES && (i < def->n_modes || def->n_modes == 0); ++i) {
        duet_mode mode = def->n_modes ? def->modes[i] : (duet_mode)i;
        if (!duet_mode_name(mode))
            break;
        if (mode_fits(&t->plan, mode))
            modes[n++] = mode;
    }
    return n;
}

void mode_search_run(tuning *t)
{
    duet_mode modes[MOST_MODES];
    uint32_t near = t->problem->start;
    const double from = t->problem->def->search ? KERNELS_END : VARIANTS_END;
    t->n_founds = t->problem->one_device ? 0 : list_modes(t, modes);
    t->stage = "share";
    for (uint32_t i = 0; i < t->n_founds; ++i) {
        t->stage_end = from + (SEARCH_END - from) * (i + 1) / t->n_founds;
        t->founds[i] = search_mode(t, modes[i], near);
        near = t->founds[i].usable ? t->founds[i].share : near;
    }
}
