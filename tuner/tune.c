// SPDX-License-Identifier: MIT
#include "tuner/tune.h"

#include "tuner/search.h"
#include "tuner/verdict.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_MODES = 8 };

static const double VARIANTS_END = 0.35, SEARCH_END = 0.7; // parts of the budget

// ---------------------------------------------------------------- variants

static const char *const default_variants[] = {"auto", "simd", "auto sort=radix", "paper"};

static const char *variant_at(const duet_tune_def *def, uint32_t i)
{
    enum { N_DEFAULT = sizeof default_variants / sizeof *default_variants };
    if (def->n_variants > 0)
        return i < def->n_variants ? def->variants[i] : NULL;
    return i < N_DEFAULT ? default_variants[i] : NULL;
}

static void set_variant(duet_plan *plan, int device, const char *variant)
{
    char *to = device == 0 ? plan->variant_a : plan->variant_b;
    snprintf(to, sizeof plan->variant_a, "%s", variant);
}

// Races the variants of one device at a share; the best one enters the plan.
static bool choose_variant(tuning *t, int device, uint32_t share, duet_error *err)
{
    static const race_options quick = {
        .least_rounds = 4, .most_rounds = 6, .level = 0.85, .dropped = 1};
    field f = {0};
    const char *variant;
    for (uint32_t i = 0; (variant = variant_at(t->task->def, i)); ++i) {
        duet_plan plan = tuning_plan_at(t, share, DUET_MODE_OWN);
        set_variant(&plan, device, variant);
        field_enter(&f, plan);
    }
    if (!tuning_race(t, &f, &quick, device == 0, true, err))
        return false;
    uint32_t leader = race_leader(&f.race);
    if (leader < f.n)
        set_variant(&t->plan, device,
                    device == 0 ? f.plans[leader].variant_a : f.plans[leader].variant_b);
    return true;
}

// As much work for A as it does in the time that B needs for all of it: its
// variants are compared there without a dear launch.
static bool find_share_of_a(tuning *t, uint32_t *share, duet_error *err)
{
    trial whole, part;
    duet_plan b_alone = tuning_plan_at(t, 0, DUET_MODE_OWN);
    duet_plan probe = tuning_plan_at(t, DUET_SHARE_ONE / 16, DUET_MODE_OWN);
    *share = probe.share;
    if (!tuning_run_trial(t, &b_alone, &whole, err) || !tuning_run_trial(t, &probe, &part, err))
        return false;
    if (whole.usable && part.usable && part.sample.a_ns > 0) {
        double fits = (double)whole.sample.total_ns / (double)part.sample.a_ns;
        *share = (uint32_t)(probe.share * fmin(fmax(fits, 1), 16));
    }
    return true;
}

static bool choose_variants(tuning *t, duet_error *err)
{
    uint32_t share;
    for (int device = 0; device < 2; ++device)
        set_variant(&t->plan, device, variant_at(t->task->def, 0));
    if (!variant_at(t->task->def, 1))
        return true;
    t->stage_end = VARIANTS_END;
    t->stage = "variant of B";
    if (!choose_variant(t, 1, 0, err))
        return false;
    t->stage = "variant of A";
    return find_share_of_a(t, &share, err) && choose_variant(t, 0, share, err);
}

// ---------------------------------------------------------------- share

// A's time for all the work, from the least and the largest part that it did.
static double expect_a_alone(const search *s)
{
    const search_sample *small = NULL, *large = NULL;
    for (uint32_t i = 0; i < s->n; ++i) {
        const search_sample *at = &s->samples[i];
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

static bool run_search(tuning *t, search *s, duet_mode mode, bool *usable, duet_error *err)
{
    *usable = true;
    while (*usable) {
        search_next next;
        trial got;
        if (!search_ask(s, &next, err))
            return false;
        t->cut |= !next.done && !tuning_within_budget(t);
        if (next.done || t->cut)
            return true;
        duet_plan plan = tuning_plan_at(t, next.share, mode);
        if (!tuning_run_trial(t, &plan, &got, err))
            return false;
        got.sample.share = next.share;
        *usable = got.usable;
        if (got.usable && !search_tell(s, &got.sample, err))
            return false;
    }
    return true;
}

// near: a share to begin from, or NULL.
static bool search_mode(tuning *t, duet_mode mode, const uint32_t *near, found *out,
                        duet_error *err)
{
    search s;
    search_options options = search_default_options();
    options.quantum = t->task->least_share;
    options.has_start = near;
    options.start = near ? *near : 0;
    if (!search_begin(&s, t->task->def->strategy, &options, err))
        return false;
    s.script = t->task->script;
    bool ok = run_search(t, &s, mode, &out->usable, err);
    out->mode = mode;
    out->usable = out->usable && s.n > 0;
    out->share = search_pick(&s);
    out->a_alone_ns = expect_a_alone(&s);
    out->b_alone_ns = s.n > 0 && search_at(&s, 0) ? (double)search_at(&s, 0)->total_ns : INFINITY;
    search_end(&s);
    return ok;
}

// One device's grid is of no use to the other where they search differently.
static bool mode_fits(const duet_plan *plan, duet_mode mode)
{
    size_t a = strcspn(plan->variant_a, " "), b = strcspn(plan->variant_b, " ");
    return mode != DUET_MODE_SHARED ||
           (a == b && strncmp(plan->variant_a, plan->variant_b, a) == 0);
}

static uint32_t list_modes(const tuning *t, duet_mode modes[MOST_MODES])
{
    const duet_tune_def *def = t->task->def;
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

// Each mode is searched from the share that was best in the one before.
static bool search_modes(tuning *t, found founds[MOST_MODES], uint32_t *n, duet_error *err)
{
    duet_mode modes[MOST_MODES];
    const uint32_t *near = t->task->has_start ? &t->task->start : NULL;
    *n = list_modes(t, modes);
    t->stage = "share";
    for (uint32_t i = 0; i < *n; ++i) {
        t->stage_end = VARIANTS_END + (SEARCH_END - VARIANTS_END) * (i + 1) / *n;
        if (!search_mode(t, modes[i], near, &founds[i], err))
            return false;
        near = founds[i].usable ? &founds[i].share : near;
    }
    return true;
}

bool tune_run(const tune_task *task, trial_log *state, duet_tune_outcome *outcome, duet_error *err)
{
    tuning t = tuning_begin(task, state);
    found founds[MOST_MODES] = {0};
    uint32_t n = 0;
    *outcome = (duet_tune_outcome){0};
    bool ok = choose_variants(&t, err) && search_modes(&t, founds, &n, err) &&
              verdict_reach(&t, founds, n, outcome, err);
    outcome->trials = state->played;
    outcome->launches = t.launches;
    outcome->seconds = (double)t.spent_ns * 1e-9;
    return ok;
}
