// SPDX-License-Identifier: MIT
// A long launch, as of 1e8 items, is a waste while plans are compared: a part of the items tells
// as well how long each takes.
#include "tuner/race.h"
#include "tuner/stages.h"
#include "tuner/trial_budget.h"

#include <string.h>

enum { LEAST_PART = 1 << 4, FINAL_ROUNDS = 3 };

static const double LONG_MS = 100;    // a launch of which a part is enough
static const double ENOUGH_MS = 25;   // that the part takes: caches hold little of it
static const double SAME_RATE = 0.95; // of a part's time for an item: twice as much takes as long
static const double FINAL_NS =
    1e10; // for all of the work by the last plans, beyond one launch each

// A tuning that is taken up goes on with the part of its first trial.
static uint32_t first_part(const tuning *t)
{
    const measure_machine *machine = &t->problem->machine;
    uint32_t part = DUET_SHARE_ONE;
    if (!machine->set_part || t->problem->meter)
        return part;
    if (t->state->n > 0)
        return (uint32_t)t->state->entries[0].scope;
    if (machine->launch_ms < LONG_MS)
        return part;
    while (part > LEAST_PART && machine->launch_ms * part / 2 >= ENOUGH_MS * DUET_SHARE_ONE)
        part /= 2;
    return part;
}

// Doubles the part until a plan would not be quicker for each item with twice as many: what a
// launch costs besides is little then.
static void grow(tuning *t, duet_plan plan)
{
    trial got = tuning_run_trial(t, &plan), more = got;
    for (; got.usable && t->part < DUET_SHARE_ONE; got = more) {
        uint32_t part = t->part;
        t->part *= 2;
        more = tuning_run_trial(t, &plan);
        if (!more.usable ||
            (double)more.sample.total_ns >= SAME_RATE * (double)got.sample.total_ns) {
            t->part = part;
            return;
        }
    }
}

void parts_choose(tuning *t)
{
    bool alike = t->problem->one_device || t->problem->fair > 0;
    t->stage = "part of the items";
    t->stage_end = VARIANTS_END;
    t->part = first_part(t);
    if (t->part == DUET_SHARE_ONE)
        return;
    grow(t, tuning_plan(t, alike ? t->problem->fair : 0, t->problem->plan.mode));
    if (!alike)
        grow(t, tuning_plan(t, DUET_SHARE_ONE, t->problem->plan.mode));
}

// The median times of the plans in turn, at least once and then as often as there is time for.
static uint32_t measure_all(tuning *t, const duet_plan *plans, uint32_t n, double medians[2])
{
    double ns[2][FINAL_ROUNDS], spent = 0;
    uint32_t r = 0;
    while (r < FINAL_ROUNDS && (r == 0 || (spent * (r + 1) / r <= FINAL_NS && tuning_goes_on(t)))) {
        for (uint32_t i = 0; i < n; ++i) {
            trial got = tuning_run_trial(t, &plans[i]);
            if (!got.usable)
                return r;
            ns[i][r] = (double)got.sample.total_ns;
            spent += ns[i][r];
        }
        ++r;
        for (uint32_t i = 0; i < n; ++i)
            medians[i] = stats_median(ns[i], r);
    }
    return r;
}

// Whether sharing is faster by a part of the items and slower by all, or the reverse.
static bool is_contradicted(const duet_tune_outcome *o, double shared, double alone)
{
    bool faster = strcmp(o->verdict, race_verdict_name(RACE_FASTER)) == 0;
    bool slower = strcmp(o->verdict, race_verdict_name(RACE_SLOWER)) == 0;
    return (faster && shared > alone) || (slower && shared < alone);
}

void parts_finish(tuning *t)
{
    duet_tune_outcome *o = t->outcome;
    const duet_plan plans[2] = {t->alone, o->best};
    uint32_t n = trial_log_same_plan(&plans[0], &plans[1]) ? 1 : 2;
    double medians[2];
    if (t->part == DUET_SHARE_ONE || t->why.status != DUET_STATUS_OK)
        return;
    t->stage = "all items";
    t->stage_end = ALL;
    t->repeats = 1;
    t->part = DUET_SHARE_ONE;
    t->at_once = true;
    uint32_t rounds = measure_all(t, plans, n, medians);
    t->at_once = false;
    if (rounds == 0)
        return;
    if (n == 2 && is_contradicted(o, medians[1], medians[0])) {
        verdict_reach(t);
        return;
    }
    bool shares = n == 2 && trial_log_same_plan(&o->plan, &plans[1]);
    double step_ms = medians[shares] * 1e-6, by = step_ms / o->step_ms;
    o->step_ms = step_ms;
    o->step_low_ms *= by;
    o->step_high_ms *= by;
    o->whole_ms = step_ms * (1 + o->whole_gain);
    o->single_ms = medians[0] * 1e-6;
}
