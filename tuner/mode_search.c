// SPDX-License-Identifier: MIT
#include "tuner/mode_search.h"

#include "tuner/joint_space.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <string.h>

// A's time for all the work, from the least and the largest part that it did.
static double expect_a_alone(const search_history *h)
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

bool mode_search_ask(tuning *t, search *s, bool *usable, duet_error *err)
{
    const bool joint = s->strategy->choice != STRATEGY_SHARE;
    for (*usable = true; *usable || joint;) {
        search_next next;
        duet_plan plan;
        trial got = {0};
        if (!search_ask(s, &next, err))
            return false;
        t->cut |= !next.done && !tuning_within_budget(t);
        if (next.done || t->cut)
            return true;
        if (joint_space_plan(s->history.space, &next.at, &plan) &&
            !tuning_run_trial(t, &plan, &got, err))
            return false;
        *usable = got.usable;
        search_sample told = got.sample;
        told.share = next.at.share;
        told.failed = !got.usable;
        memcpy(told.configs, next.at.configs, sizeof told.configs);
        if ((*usable || joint) && !search_tell(s, &told, err))
            return false;
    }
    return true;
}

// near: a share to begin from, or NULL.
static bool search_mode(tuning *t, duet_mode mode, const uint32_t *near, mode_found *out,
                        duet_error *err)
{
    search s;
    const joint_space share_alone = {.base = tuning_plan(t, 0, mode)};
    search_options options = search_default_options();
    options.quantum = t->problem->least_share;
    options.has_start = near;
    options.start = near ? *near : 0;
    if (!search_begin(&s, t->problem->def->strategy, &options, err))
        return false;
    s.history.script = t->problem->script;
    s.history.space = &share_alone;
    bool ok = mode_search_ask(t, &s, &out->usable, err);
    out->mode = mode;
    out->usable = out->usable && s.history.n > 0;
    out->share = search_pick(&s);
    // One device alone may only seem the best if the search was cut short.
    if (t->cut && (out->share == 0 || out->share == DUET_SHARE_ONE))
        out->share = search_history_first_share(&s.history);
    out->a_alone_ns = expect_a_alone(&s.history);
    const search_sample *b_alone = search_history_at(&s.history, 0);
    out->b_alone_ns = b_alone ? (double)b_alone->total_ns : INFINITY;
    search_end(&s);
    return ok;
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

bool mode_search_run(tuning *t, mode_found founds[MOST_MODES], uint32_t *n, duet_error *err)
{
    duet_mode modes[MOST_MODES];
    const uint32_t *near = t->problem->start ? &t->problem->start : NULL;
    *n = t->problem->one_device ? 0 : list_modes(t, modes);
    t->stage = "share";
    for (uint32_t i = 0; i < *n; ++i) {
        double from = t->problem->def->search ? KERNELS_END : VARIANTS_END;
        t->stage_end = from + (SEARCH_END - from) * (i + 1) / *n;
        if (!search_mode(t, modes[i], near, &founds[i], err))
            return false;
        near = founds[i].usable ? &founds[i].share : near;
    }
    return true;
}
