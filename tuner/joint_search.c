// SPDX-License-Identifier: MIT
#include "tuner/joint_search.h"

#include "tuner/field.h"
#include "tuner/joint_space.h"
#include "tuner/kernel_tuning.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdlib.h>

enum { POINTS = 16, FINALISTS = 6 };

static const race_options finals = {
    .least_rounds = 6, .most_rounds = 12, .confidence = 0.95, .dropped = 1.1, .margin = 0.02};

static const strategy *strategy_for(const tune_problem *problem)
{
    return strategy_of(problem->def->strategy, problem->script);
}

bool joint_search_is_asked(const tune_problem *problem)
{
    const strategy *s = strategy_for(problem);
    return s && s->choice != STRATEGY_SHARE;
}

// ---------------------------------------------------------------- space

// Keeps those that the search is meant for.
static uint32_t keep_meant(const duet_tune_def *def, kernel_space *spaces, uint32_t n)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n && kept < SEARCH_KERNELS; ++i)
        if (kernel_tuning_is_meant(def->search, &spaces[i]))
            spaces[kept++] = spaces[i];
    return kept;
}

static bool read_space(tuning *t, joint_space *s, duet_error *err)
{
    const tune_problem *problem = t->problem;
    uint32_t half = problem->one_device ? 0 : DUET_SHARE_ONE / 2;
    duet_mode mode = problem->def->n_modes ? problem->def->modes[0] : DUET_MODE_OWN;
    trial got;
    *s = (joint_space){.points = problem->one_device ? 0 : POINTS,
                       .base = tuning_plan(t, half, mode)};
    if (!tuning_run_trial(t, &s->base, &got, err))
        return false;
    for (int device = 0; problem->def->search && got.usable && device < 2; ++device) {
        uint32_t n = 0;
        if (problem->one_device && device == 0)
            continue;
        if (!problem->kernels.read(problem->kernels.context, &s->base, device, &s->kernels[device],
                                   &n, err))
            return false;
        s->n_kernels[device] = keep_meant(problem->def, s->kernels[device], n);
    }
    return true;
}

// ---------------------------------------------------------------- search

static uint32_t count_samples(const strategy *of, const joint_space *space)
{
    enum { LEAST = 24, MOST = 400, ALL_PLANS = 100000 };
    uint64_t n = joint_space_count(space);
    if (of->choice == STRATEGY_JOINT_ALL)
        return (uint32_t)(n < ALL_PLANS ? n : ALL_PLANS);
    return n / 10 < LEAST ? LEAST : n / 10 > MOST ? MOST : (uint32_t)(n / 10);
}

static bool run_strategy(tuning *t, search *s, duet_error *err)
{
    bool usable;
    s->history.options.launches = count_samples(s->strategy, s->history.space);
    t->search_known = true;
    t->search_trials = s->history.options.launches + FINALISTS * finals.most_rounds;
    return mode_search_ask(t, s, &usable, err);
}

// ---------------------------------------------------------------- choice

static int by_time(const void *a, const void *b)
{
    const search_sample *x = a, *y = b;
    if (x->failed != y->failed)
        return x->failed ? 1 : -1;
    return (x->total_ns > y->total_ns) - (x->total_ns < y->total_ns);
}

// The best of many short times is mostly one that was lucky, so the best few race.
static bool race_best_few(tuning *t, const search_history *h, duet_plan *best, duet_error *err)
{
    field f = {0};
    for (uint32_t i = 0; i < h->n && f.n < FINALISTS; ++i) {
        duet_plan plan;
        if (!h->samples[i].failed && joint_space_plan(h->space, &h->samples[i], &plan))
            field_enter_new(&f, &plan);
    }
    if (f.n == 0)
        return true;
    *best = f.plans[0];
    if (!field_race(t, &f, &finals, false, INFINITY, err))
        return false;
    uint32_t winner = race_best(&f.race, 0, f.n);
    *best = f.plans[winner < f.n ? winner : 0];
    return true;
}

// The least that a device would take for all the work, by its part in any launch.
static double expect_alone(const search_history *h, int device)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        uint32_t part = device == 0 ? at->share : SEARCH_ONE - at->share;
        uint64_t ns = device == 0 ? at->a_ns : at->b_ns;
        if (!at->failed && part > 0 && ns > 0)
            least = fmin(least, (double)ns * SEARCH_ONE / part);
    }
    return least;
}

static bool choose(tuning *t, search_history *h, mode_found *found, duet_error *err)
{
    duet_plan best = h->space->base;
    *found = (mode_found){
        .mode = best.mode, .a_alone_ns = expect_alone(h, 0), .b_alone_ns = expect_alone(h, 1)};
    qsort(h->samples, h->n, sizeof *h->samples, by_time);
    found->usable = h->n > 0 && !h->samples[0].failed;
    if (!race_best_few(t, h, &best, err))
        return false;
    found->share = best.share;
    plan_set_variant(&t->plan, 0, best.variant_a);
    plan_set_variant(&t->plan, 1, best.variant_b);
    return true;
}

bool joint_search_run(tuning *t, mode_found *found, uint32_t *n, duet_tune_outcome *told,
                      duet_error *err)
{
    *n = 1;
    joint_space s = {0};
    search joint = {
        .strategy = strategy_for(t->problem),
        .history = {.space = &s, .script = t->problem->script, .seed = t->problem->def->seed}};
    t->stage = "kernels and share";
    t->stage_end = SEARCH_END;
    bool ok = read_space(t, &s, err) && run_strategy(t, &joint, err);
    uint64_t plans = joint_space_count(&s);
    told->plans = plans < UINT32_MAX ? (uint32_t)plans : UINT32_MAX;
    told->plans_tried = joint.history.n;
    ok = ok && choose(t, &joint.history, found, err);
    search_end(&joint);
    joint_space_free(&s);
    return ok;
}
