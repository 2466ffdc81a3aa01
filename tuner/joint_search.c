// SPDX-License-Identifier: MIT
#include "tuner/joint_search.h"

#include "tuner/field.h"
#include "tuner/joint_strategy.h"
#include "tuner/kernel_tuning.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdlib.h>

enum { POINTS = 16, FINALISTS = 6 };

static const race_options finals = {
    .least_rounds = 6, .most_rounds = 12, .confidence = 0.95, .dropped = 1.1, .margin = 0.02};

bool joint_search_is_asked(const tune_task *task)
{
    return joint_strategy_of(task->def->strategy, task->script);
}

// ---------------------------------------------------------------- space

// Keeps those that the search is meant for.
static uint32_t keep_meant(const duet_tune_def *def, kernel_space *spaces, uint32_t n)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n && kept < JOINT_KERNELS; ++i)
        if (kernel_tuning_is_meant(def->search, &spaces[i]))
            spaces[kept++] = spaces[i];
    return kept;
}

static bool read_space(tuning *t, joint_space *s, duet_error *err)
{
    const tune_task *task = t->task;
    uint32_t half = task->one_device ? 0 : DUET_SHARE_ONE / 2;
    duet_mode mode = task->def->n_modes ? task->def->modes[0] : DUET_MODE_OWN;
    trial got;
    *s = (joint_space){.points = task->one_device ? 0 : POINTS, .base = tuning_plan(t, half, mode)};
    if (!tuning_run_trial(t, &s->base, &got, err))
        return false;
    for (int device = 0; task->def->search && got.usable && device < 2; ++device) {
        uint32_t n = 0;
        if (task->one_device && device == 0)
            continue;
        if (!task->kernels.read(task->kernels.context, &s->base, device, &s->kernels[device], &n,
                                err))
            return false;
        s->n_kernels[device] = keep_meant(task->def, s->kernels[device], n);
    }
    return true;
}

// ---------------------------------------------------------------- search

static bool measure(tuning *t, joint_history *h, const joint_point *at, duet_error *err)
{
    trial got = {0};
    duet_plan plan;
    bool fits = joint_space_plan(h->space, at, &plan);
    if (fits && !tuning_run_trial(t, &plan, &got, err))
        return false;
    return joint_history_add(
        h, &(joint_sample){.at = *at, .usable = got.usable, .times = got.sample}, err);
}

static bool run_strategy(tuning *t, joint_history *h, duet_error *err)
{
    const joint_strategy *strategy = joint_strategy_of(t->task->def->strategy, t->task->script);
    h->most = joint_strategy_samples(strategy, h->space);
    t->search_known = true;
    t->search_trials = h->most + FINALISTS * finals.most_rounds;
    while (h->n < h->most) {
        joint_next next;
        if (!strategy->ask(h, &next, err))
            return false;
        t->cut |= !next.done && !tuning_within_budget(t);
        if (next.done || t->cut)
            return true;
        if (!measure(t, h, &next.at, err))
            return false;
    }
    return true;
}

// ---------------------------------------------------------------- choice

static int by_time(const void *a, const void *b)
{
    const joint_sample *x = a, *y = b;
    if (x->usable != y->usable)
        return x->usable ? -1 : 1;
    return (x->times.total_ns > y->times.total_ns) - (x->times.total_ns < y->times.total_ns);
}

static bool has_entered(const field *f, const duet_plan *plan)
{
    bool entered = false;
    for (uint32_t i = 0; i < f->n; ++i)
        entered |= trial_log_same_plan(&f->plans[i], plan);
    return entered;
}

// The best of many short times is mostly one that was lucky, so the best few race.
static bool race_best_few(tuning *t, const joint_history *h, duet_plan *best, duet_error *err)
{
    field f = {0};
    for (uint32_t i = 0; i < h->n && f.n < FINALISTS; ++i) {
        duet_plan plan;
        bool fits = h->samples[i].usable && joint_space_plan(h->space, &h->samples[i].at, &plan);
        if (fits && !has_entered(&f, &plan))
            field_enter(&f, plan);
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
static double expect_alone(const joint_history *h, int device)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < h->n; ++i) {
        const joint_sample *at = &h->samples[i];
        uint32_t part = device == 0 ? at->at.share : SEARCH_ONE - at->at.share;
        uint64_t ns = device == 0 ? at->times.a_ns : at->times.b_ns;
        if (at->usable && part > 0 && ns > 0)
            least = fmin(least, (double)ns * SEARCH_ONE / part);
    }
    return least;
}

static bool choose(tuning *t, joint_history *h, mode_found *found, duet_error *err)
{
    duet_plan best = h->space->base;
    *found = (mode_found){
        .mode = best.mode, .a_alone_ns = expect_alone(h, 0), .b_alone_ns = expect_alone(h, 1)};
    qsort(h->samples, h->n, sizeof *h->samples, by_time);
    found->usable = h->n > 0 && h->samples[0].usable;
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
    joint_history h = {.space = &s, .script = t->task->script, .seed = t->task->def->seed};
    t->stage = "kernels and share";
    t->stage_end = SEARCH_END;
    bool ok = read_space(t, &s, err) && run_strategy(t, &h, err);
    uint64_t plans = joint_space_count(&s);
    told->plans = plans < UINT32_MAX ? (uint32_t)plans : UINT32_MAX;
    told->plans_tried = h.n;
    ok = ok && choose(t, &h, found, err);
    joint_history_free(&h);
    joint_space_free(&s);
    return ok;
}
