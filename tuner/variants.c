// SPDX-License-Identifier: MIT
#include "tuner/field.h"
#include "tuner/stages.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <string.h>

static const double HOPELESS = 2.0; // a plan this much slower is dropped from a quick race

// Races the variants of one device at a share; the best one enters the plan.
static void choose_variant(tuning *t, int device, uint32_t share)
{
    field f = {.of_a = device == 0, .hopeless = HOPELESS};
    const char *variant;
    for (uint32_t i = 0; (variant = tune_variant(t->problem->def, i)); ++i) {
        duet_plan plan = tuning_plan(t, share, DUET_MODE_OWN);
        plan_set_variant(&plan, device, variant);
        field_enter(&f, plan);
    }
    field_race(t, &f, &trial_budget_quick_race);
    uint32_t leader = race_leader(&f.race);
    if (leader < f.n)
        plan_set_variant(&t->plan, device, plan_variant(&f.plans[leader], device));
}

uint32_t variants_share_of_a(tuning *t)
{
    duet_plan b_alone = tuning_plan(t, 0, DUET_MODE_OWN);
    duet_plan probe = tuning_plan(t, DUET_SHARE_ONE / 16, DUET_MODE_OWN);
    trial whole = tuning_run_trial(t, &b_alone), part = tuning_run_trial(t, &probe);
    if (!whole.usable || !part.usable || part.sample.a_ns == 0)
        return probe.share;
    double fits = (double)whole.sample.total_ns / (double)part.sample.a_ns;
    return (uint32_t)(probe.share * fmin(fmax(fits, 1), 16));
}

// No verdict follows for a device that shares with none. So the winner of the quick race is used
// only if it is surely faster than the usual variant, if that is among those to try.
static void confirm_variant(tuning *t, const char *usual)
{
    if (!tune_has_variant(t->problem->def, usual) || strcmp(t->plan.variant_b, usual) == 0)
        return;
    duet_plan winner = tuning_plan(t, 0, DUET_MODE_OWN), before = winner;
    plan_set_variant(&before, 1, usual);
    t->stage_end = VERDICT_END;
    if (field_duel(t, &before, &winner, &trial_budget_last_race).verdict != RACE_FASTER)
        plan_set_variant(&t->plan, 1, usual);
}

void variants_choose(tuning *t)
{
    const duet_plan usual = t->plan;
    for (int device = 0; device < 2; ++device)
        plan_set_variant(&t->plan, device, tune_variant(t->problem->def, 0));
    if (!tune_variant(t->problem->def, 1))
        return;
    t->stage_end = VARIANTS_END;
    t->stage = "variant of B";
    choose_variant(t, 1, 0);
    if (t->problem->one_device) {
        confirm_variant(t, usual.variant_b);
        plan_set_variant(&t->plan, 0, t->plan.variant_b);
    } else {
        t->stage = "variant of A";
        choose_variant(t, 0, variants_share_of_a(t));
    }
}
