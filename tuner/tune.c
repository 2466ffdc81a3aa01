// SPDX-License-Identifier: MIT
#include "tuner/tune.h"

#include "base/error.h"
#include "tuner/race.h"
#include "tuner/stages.h"
#include "tuner/stats.h"

#include <math.h>
#include <stdio.h>

bool tune_gave_up(const duet_tune_outcome *outcome)
{
    return outcome->step_ms == 0;
}

// The default plan, of which nothing is known.
static duet_tune_outcome nothing_known(const tuning *t)
{
    return (duet_tune_outcome){.plan = t->problem->plan,
                               .best = t->problem->plan,
                               .single_ms = NAN,
                               .whole_ms = NAN,
                               .whole_gain = NAN,
                               .whole_gain_low = NAN,
                               .whole_gain_high = NAN};
}

static void give_up(const tuning *t, duet_tune_outcome *outcome)
{
    *outcome = nothing_known(t);
    snprintf(outcome->verdict, sizeof outcome->verdict, "%s", race_verdict_name(RACE_AMBIGUOUS));
    snprintf(outcome->unused, sizeof outcome->unused, "other programs had %s",
             tuning_describe_others(t).chars);
}

// ---------------------------------------------------------------- energy

static double median_ms(const trial_log *log, const duet_plan *plan)
{
    double ms[STATS_MOST];
    uint32_t n = 0;
    for (const trial *at = NULL;
         n < STATS_MOST && (at = trial_log_of(log, plan, DUET_SHARE_ONE, at)); ++n)
        ms[n] = (double)at->sample.total_ns * 1e-6;
    return n ? stats_median(ms, n) : NAN;
}

// The verdict raced what launches take in nJ as others do in ns: those are the energy, and the
// times are in the log. The gain stays that of energy.
static void separate_energy(const tuning *t, duet_tune_outcome *o)
{
    o->terms.joules = o->step_ms * 1e-3;
    o->single_joules = o->single_ms * 1e-3;
    o->step_ms = o->step_low_ms = o->step_high_ms = median_ms(t->state, &o->plan);
    duet_plan alone = o->plan;
    if (alone.share < DUET_SHARE_ONE)
        alone.share = 0;
    alone.mode = DUET_MODE_OWN;
    o->single_ms = median_ms(t->state, &alone);
}

// ---------------------------------------------------------------- a tuning

bool tune_run(const tune_problem *problem, trial_log *state, duet_tune_outcome *outcome,
              duet_error *err)
{
    tuning t = {.problem = problem,
                .state = state,
                .outcome = outcome,
                .plan = problem->plan,
                .repeats = problem->def->repeats,
                .scatter = INFINITY,
                .part = DUET_SHARE_ONE,
                .search_trials = problem->def->search ? UINT32_MAX : 0};
    state->played = 0;
    *outcome = nothing_known(&t);
    parts_choose(&t);
    variants_choose(&t);
    plan_search_run(&t);
    verdict_reach(&t);
    verdict_race_whole(&t);
    parts_finish(&t);
    bool ok = t.why.status == DUET_STATUS_OK;
    if (ok && problem->meter)
        separate_energy(&t, outcome);
    if (!ok && tuning_is_out_of_patience(&t)) {
        give_up(&t, outcome);
        ok = true;
    } else if (!ok) {
        error_copy(err, &t.why);
    }
    outcome->watched = t.watched;
    outcome->disturbed = t.disturbed;
    outcome->trials = state->played;
    outcome->launches = t.launches;
    outcome->seconds = (double)(t.spent_ns + t.waited_ns) * 1e-9;
    return ok;
}
