// SPDX-License-Identifier: MIT
#include "tuner/tuning.h"

#include "base/budget.h"
#include "base/error.h"

#include <string.h>

static const double HOPELESS = 2.0; // a plan this much slower is dropped from a quick race

tuning tuning_begin(const tune_task *task, trial_log *state)
{
    state->played = 0;
    return (tuning){
        .task = task, .state = state, .plan = task->plan, .repeats = task->def->repeats};
}

// ---------------------------------------------------------------- a trial

bool tuning_within_budget(const tuning *t)
{
    const duet_tune_def *def = t->task->def;
    bool in_time =
        def->budget_seconds <= 0 || (double)t->spent_ns * 1e-9 < t->stage_end * def->budget_seconds;
    bool in_trials =
        def->budget_trials == 0 || t->state->played < t->stage_end * def->budget_trials;
    return in_time && in_trials;
}

static bool tell_watcher(const tuning *t, const trial_log_entry *entry, bool remembered,
                         duet_error *err)
{
    const duet_tune_def *def = t->task->def;
    duet_tune_progress progress = {
        .stage = t->stage,
        .plan = &entry->plan,
        .ms = (double)entry->sample.total_ns * 1e-6,
        .trials = t->state->played,
        .launches = t->launches,
        .seconds = (double)t->spent_ns * 1e-9,
        .remembered = remembered,
    };
    if (def->watch && !def->watch(def->watch_context, &progress))
        return error_set(err, DUET_STATUS_INTERRUPTED,
                         "stopped after %u trials; the same command goes on from there",
                         progress.trials);
    return true;
}

static trial_log_entry entry_of(const duet_plan *plan, const measurement *m)
{
    const profile_sample *typical = &m->samples[m->typical];
    trial_log_entry entry = {
        .plan = *plan,
        .usable = strcmp(m->outcome, "ok") == 0,
        .sample = {.share = plan->share},
        .launches = m->n_samples,
        .spent_ns = m->spent_ns,
    };
    if (entry.usable) {
        entry.sample.total_ns = (uint64_t)typical->total_ns;
        entry.sample.a_ns = (uint64_t)typical->a_ns;
        entry.sample.b_ns = (uint64_t)typical->b_ns;
        entry.terms = m->terms;
    }
    return entry;
}

static bool has_default_variants(const tune_task *task, const duet_plan *plan)
{
    return strcmp(plan->variant_a, task->plan.variant_a) == 0 &&
           strcmp(plan->variant_b, task->plan.variant_b) == 0;
}

// The default variants must be right; any other that is wrong is passed over.
static bool check_measured(tuning *t, const duet_plan *plan, const measurement *m, duet_error *err)
{
    if (strcmp(m->outcome, "ok") == 0)
        return true;
    error_set(&t->failure, m->failure.status, "no plan runs: %s", m->failure.text);
    if (strcmp(m->outcome, "wrong") == 0 && has_default_variants(t->task, plan))
        return error_set(err, DUET_STATUS_WRONG_RESULT,
                         "share %u of %u, variants '%s' and '%s': %s", plan->share, DUET_SHARE_ONE,
                         plan->variant_a, plan->variant_b, m->failure.text);
    return true;
}

static bool measure_live(tuning *t, const duet_plan *plan, trial_log_entry *entry, duet_error *err)
{
    const tune_task *task = t->task;
    if (!budget_check(err))
        return false;
    measurement m = measure_plan(&task->machine, plan, t->repeats);
    *entry = entry_of(plan, &m);
    if (!trial_log_add(t->state, entry, err))
        return false;
    ++t->state->played;
    const tune_recorder *recorder = &task->recorder;
    return (!recorder->trial || recorder->trial(recorder->context, plan, &m, t->state, err)) &&
           check_measured(t, plan, &m, err);
}

// From the log, or else from the machine.
bool tuning_run_trial(tuning *t, const duet_plan *plan, trial *out, duet_error *err)
{
    const trial_log_entry *kept = trial_log_next(t->state, plan);
    trial_log_entry entry;
    *out = (trial){0};
    if (kept)
        entry = *kept;
    else if (!measure_live(t, plan, &entry, err))
        return false;
    t->launches += entry.launches;
    t->spent_ns += entry.spent_ns;
    out->usable = entry.usable;
    out->sample = entry.sample;
    out->terms = entry.terms;
    return tell_watcher(t, &entry, kept, err);
}

duet_plan tuning_plan_at(const tuning *t, uint32_t share, duet_mode mode)
{
    duet_plan plan = t->plan;
    plan.share = share;
    plan.mode = mode;
    return plan;
}

// ---------------------------------------------------------------- races

void field_enter(field *f, duet_plan plan)
{
    if (f->n < RACE_RIVALS)
        f->plans[f->n++] = plan;
}

// What is so much slower is not worth another round.
static void drop_hopeless(race *r)
{
    uint32_t leader = race_leader(r);
    for (uint32_t i = 0; i < r->n && leader < r->n; ++i) {
        if (r->rivals[i].rounds > 0 && race_compare(r, leader, i).ratio > HOPELESS)
            race_drop(r, i);
    }
}

bool tuning_race(tuning *t, field *f, const race_options *options, bool of_a, bool quick,
                 duet_error *err)
{
    uint32_t rival;
    f->race = race_begin(f->n, options);
    while (tuning_within_budget(t) && race_next(&f->race, &rival)) {
        trial got;
        if (!tuning_run_trial(t, &f->plans[rival], &got, err))
            return false;
        double ns = (double)(of_a ? got.sample.a_ns : got.sample.total_ns);
        if (got.usable)
            race_add(&f->race, rival, ns);
        else
            race_drop(&f->race, rival);
        if (quick)
            drop_hopeless(&f->race);
        f->terms[rival] = got.terms;
    }
    return true;
}
