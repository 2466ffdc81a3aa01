// SPDX-License-Identifier: MIT
#include "tuner/tuning.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

duet_plan tuning_plan(const tuning *t, uint32_t share, duet_mode mode)
{
    duet_plan plan = t->plan;
    plan.share = share;
    plan.mode = mode;
    return plan;
}

bool tuning_goes_on(const tuning *t)
{
    const duet_tune_def *def = t->problem->def;
    double spent_s = (double)(t->spent_ns + t->waited_ns) * 1e-9;
    bool in_time = def->budget_seconds <= 0 || spent_s < t->stage_end * def->budget_seconds;
    bool in_trials =
        def->budget_trials == 0 || t->state->played < trial_budget_end(t->problem, t->stage_end);
    return t->why.status == DUET_STATUS_OK && in_time && in_trials;
}

uint32_t tuning_count_launches(const tuning *t, uint32_t usual)
{
    enum { MOST = 8 };
    static const double enough_ns = 5e6, steady = 0.05;
    uint32_t played = t->state->played;
    if (t->scatter <= steady)
        return usual;
    double ns = played > 0 ? (double)t->state->entries[played - 1].sample.total_ns : enough_ns;
    return (uint32_t)fmax(fmin(ceil(enough_ns / fmax(ns, 1)), MOST), usual);
}

// One launch counts if the first trial's took a second: nothing disturbs the whole of it, and of
// longer ones a tuning has few.
static uint32_t limit_launches(const tuning *t, uint32_t n)
{
    static const uint64_t long_ns = UINT64_C(1000000000);
    bool long_ones = t->state->played > 0 && t->state->entries[0].sample.total_ns >= long_ns;
    return long_ones ? 1 : n;
}

// Checks after the first trial, whose kernels were built in it, whether the time can suffice: each
// trial takes at least half as long as one device alone.
static bool check_budget(tuning *t, const trial *first, double launch_s)
{
    const duet_tune_def *def = t->problem->def;
    double least_s = (double)t->spent_ns * 1e-9 + 0.5 * launch_s *
                                                      (1 + limit_launches(t, VERDICT_REPEATS)) *
                                                      trial_budget_least(def);
    return def->budget_seconds <= 0 || least_s <= def->budget_seconds ||
           bad_argument(&t->why,
                        "a budget of %.3g s ends before a verdict: a step takes %.3g s; expected "
                        "at least %.3g s",
                        def->budget_seconds, (double)first->sample.total_ns * 1e-9,
                        ceil(10 * least_s) / 10);
}

bool tuning_stop(tuning *t)
{
    return error_set(&t->why, DUET_STATUS_INTERRUPTED,
                     "stopped after %u trial%s; the same command goes on from there",
                     t->state->played, t->state->played == 1 ? "" : "s");
}

// Until it is known what the kernels' search takes, only the budget limits the trials.
static uint32_t most_trials(const tuning *t)
{
    bool known = t->search_trials != UINT32_MAX;
    return known ? trial_budget_most(t->problem, t->search_trials) : t->problem->def->budget_trials;
}

// About: what was spent, the trials to come at the mean of those so far, and at the end all of the
// work by two plans. 0 until it is known what the kernels' search takes.
static double expect_seconds(const tuning *t)
{
    uint32_t trials = trial_budget_likely(t->problem, t->search_trials), played = t->state->played;
    double spent_s = (double)t->spent_ns * 1e-9;
    double all_s = t->part < DUET_SHARE_ONE ? 4e-3 * t->problem->machine.launch_ms : 0;
    if (t->search_trials == UINT32_MAX || played == 0)
        return 0;
    return spent_s + (trials > played ? spent_s / played * (trials - played) : 0) + all_s;
}

static duet_tune_progress progress_of(const tuning *t, const duet_plan *plan)
{
    return (duet_tune_progress){.stage = t->stage,
                                .plan = plan,
                                .trials = t->state->played,
                                .launches = t->launches,
                                .seconds = (double)t->spent_ns * 1e-9};
}

static bool tell_watcher(tuning *t, const duet_tune_progress *progress)
{
    const duet_tune_def *def = t->problem->def;
    return !def->watch || def->watch(def->watch_context, progress) || tuning_stop(t);
}

static bool tell_trial(tuning *t, const trial *got, bool remembered)
{
    duet_tune_progress progress = progress_of(t, &got->plan);
    progress.ms = (double)got->sample.total_ns * 1e-6;
    progress.most_trials = most_trials(t);
    progress.expected_seconds = expect_seconds(t);
    progress.remembered = remembered;
    return tell_watcher(t, &progress);
}

// ---------------------------------------------------------------- other programs

// A look at other programs before the next try, which may succeed beside them too.
// While no other program has a core: of a trial, and of all.
enum { QUIET_TRIES = 5, MOST_QUIET_TRIES = 60 };
#define LOOK_NS UINT64_C(100000000)
#define NEXT_TRY_NS UINT64_C(2000000000)

static core_others look_at_others(const tuning *t)
{
    const measure_machine *machine = &t->problem->machine;
    return machine->look_at_others ? machine->look_at_others(machine->context) : (core_others){0};
}

tuning_others tuning_describe_others(const tuning *t)
{
    core_others others = look_at_others(t);
    tuning_others words;
    snprintf(words.chars, sizeof words.chars, "%.1f of %u core%s", others.cores, others.of,
             others.of == 1 ? "" : "s");
    return words;
}

// The budget may end before the patience.
bool tuning_is_out_of_patience(const tuning *t)
{
    const duet_tune_def *def = t->problem->def;
    double most = def->wait_seconds;
    if (def->budget_seconds > 0)
        most = fmin(most, def->budget_seconds - (double)t->spent_ns * 1e-9);
    return t->waited_ns > 0 && (double)t->waited_ns * 1e-9 >= most;
}

static bool tell_waiting(tuning *t, const duet_plan *plan)
{
    char waiting[128];
    duet_tune_progress progress = progress_of(t, plan);
    snprintf(waiting, sizeof waiting, "other programs have %s", tuning_describe_others(t).chars);
    progress.seconds += (double)t->waited_ns * 1e-9;
    progress.waiting = waiting;
    if (!budget_check_stop(NULL) || tuning_is_out_of_patience(t))
        return tuning_stop(t);
    return tell_watcher(t, &progress);
}

// Until other programs leave the cores, or for a while.
static bool wait_for_quiet(tuning *t, const duet_plan *plan)
{
    uint64_t waited_ns = 0;
    do {
        if (!tell_waiting(t, plan))
            return false;
        clock_sleep_ns(LOOK_NS);
        waited_ns += LOOK_NS;
        t->waited_ns += LOOK_NS;
    } while (look_at_others(t).is_crowded && waited_ns < NEXT_TRY_NS);
    return true;
}

// The system puts threads on other cores after a while.
static bool wait_for_scheduler(tuning *t)
{
    clock_sleep_ns(LOOK_NS);
    t->spent_ns += LOOK_NS;
    return budget_check_stop(NULL) || tuning_stop(t);
}

// Measures until enough launches of the trial were undisturbed, as many as usual after the first
// try. While no other program has a core the machine is as quiet as it can be: after some tries the
// launches count as they are. A machine whose threads are always in each other's way must not cost
// every trial so many.
static bool measure_in_quiet(tuning *t, const measure_machine *machine, const duet_plan *plan,
                             measure_way way, measurement *m)
{
    uint32_t tries = 0, usual = t->problem->def->repeats;
    way.quiet = t->problem->def->wait_seconds > 0 && !t->at_once;
    way.repeats = limit_launches(t, way.repeats);
    *m = measure_plan(machine, plan, way);
    while (m->failure.status == DUET_STATUS_OK && m->counted < way.repeats) {
        t->watched += m->trial.watched;
        t->disturbed += m->trial.disturbed;
        bool crowded = look_at_others(t).is_crowded;
        *(crowded ? &t->waited_ns : &t->spent_ns) += m->trial.spent_ns;
        way.quiet = crowded || (++tries < QUIET_TRIES && t->quiet_tries++ < MOST_QUIET_TRIES);
        if (way.quiet && !(crowded ? wait_for_quiet(t, plan) : wait_for_scheduler(t)))
            return false;
        way.repeats = way.repeats < usual ? way.repeats : usual;
        *m = measure_plan(machine, plan, way);
    }
    return m->failure.status != DUET_STATUS_INTERRUPTED || tuning_stop(t);
}

// ---------------------------------------------------------------- trials

static bool has_default_variants(const tune_problem *problem, const duet_plan *plan)
{
    return strcmp(plan->variant_a, problem->plan.variant_a) == 0 &&
           strcmp(plan->variant_b, problem->plan.variant_b) == 0;
}

// The default variants must be right; any other that is wrong is passed over.
static bool check_measured(tuning *t, const duet_plan *plan, const measurement *m)
{
    if (m->trial.usable)
        return true;
    error_set(&t->failure, m->failure.status, "no plan runs: %s", m->failure.text);
    if (strcmp(m->row.outcome, "wrong") == 0 && has_default_variants(t->problem, plan))
        return error_set(&t->why, DUET_STATUS_WRONG_RESULT,
                         "share %u of %u, variants '%s' and '%s': %s", plan->share, DUET_SHARE_ONE,
                         plan->variant_a, plan->variant_b, m->failure.text);
    return true;
}

// Its programs are built, for it ran in this process, and the stages of a first launch are not
// needed.
static bool is_warm(const tuning *t, const duet_plan *plan)
{
    bool warm = false, counts = t->focus.stages || t->at_once || t->part < DUET_SHARE_ONE;
    for (uint32_t i = t->first; counts && i < t->state->played && !warm; ++i)
        warm = trial_log_same_plan(&t->state->entries[i].plan, plan);
    return warm;
}

static int32_t scope_of(const tuning *t, const measure_machine *whole)
{
    return whole ? -(int32_t)t->part : (int32_t)t->part;
}

static bool measure_live(tuning *t, const measure_machine *whole, const duet_plan *plan, trial *got)
{
    const tune_recorder *recorder = &t->problem->recorder;
    const measure_way way = {.repeats = t->repeats,
                             .warm = is_warm(t, plan),
                             .staged = t->focus.stages,
                             .meter = t->problem->meter};
    const measure_machine *machine = whole ? whole : &t->problem->machine;
    measurement m;
    if (machine->set_part)
        machine->set_part(machine->context, t->part);
    if (!budget_check(&t->why) || !measure_in_quiet(t, machine, plan, way, &m))
        return false;
    m.trial.scope = scope_of(t, whole);
    if (m.trial.usable && t->focus.stages)
        m.trial.focus_ns =
            measure_stages_ns(&m.launch, t->focus.device, t->focus.stages, t->focus.n);
    *got = m.trial;
    if (!trial_log_add(t->state, got, &t->why))
        return false;
    uint32_t number = t->state->played++;
    return (!recorder->trial || recorder->trial(recorder->context, number, &m, &t->why)) &&
           (whole || check_measured(t, plan, &m));
}

static void count_trial(tuning *t, const trial *entry)
{
    t->launches += entry->launches;
    t->watched += entry->watched;
    t->disturbed += entry->disturbed;
    t->spent_ns += entry->spent_ns;
}

// Takes the times for those of all the work, at the rate of the part.
static void scale(const tuning *t, trial *got)
{
    uint64_t *times[] = {&got->sample.total_ns, &got->sample.a_ns, &got->sample.b_ns,
                         &got->focus_ns};
    for (uint32_t i = 0; i < sizeof times / sizeof *times; ++i)
        *times[i] = (uint64_t)((double)*times[i] * DUET_SHARE_ONE / t->part + 0.5);
}

trial tuning_run_on(tuning *t, const measure_machine *whole, const duet_plan *plan)
{
    trial got = {0};
    if (t->why.status != DUET_STATUS_OK)
        return got;
    const trial *kept = trial_log_next(t->state, plan, scope_of(t, whole));
    if (kept)
        got = *kept;
    else if (!measure_live(t, whole, plan, &got))
        return (trial){0};
    t->first = kept ? t->state->played : t->first;
    count_trial(t, &got);
    double launch_s = (double)got.sample.total_ns * 1e-9;
    scale(t, &got);
    if (tell_trial(t, &got, kept) && t->state->played == 1)
        check_budget(t, &got, launch_s);
    if (t->problem->meter) // races and searches make this small
        got.sample.total_ns = (uint64_t)(got.terms.joules * 1e9);
    return got;
}

trial tuning_run_trial(tuning *t, const duet_plan *plan)
{
    return tuning_run_on(t, NULL, plan);
}
