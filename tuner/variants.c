// SPDX-License-Identifier: MIT
#include "tuner/variants.h"

#include "tuner/field.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <string.h>

static const double HOPELESS = 2.0; // a plan this much slower is dropped from a quick race

// Races the variants of one device at a share; the best one enters the plan.
static bool choose_variant(tuning *t, int device, uint32_t share, duet_error *err)
{
    field f = {0};
    const char *variant;
    for (uint32_t i = 0; (variant = tune_variant(t->problem->def, i)); ++i) {
        duet_plan plan = tuning_plan(t, share, DUET_MODE_OWN);
        plan_set_variant(&plan, device, variant);
        field_enter(&f, plan);
    }
    if (!field_race(t, &f, &trial_budget_quick_race, device == 0, HOPELESS, err))
        return false;
    uint32_t leader = race_leader(&f.race);
    if (leader < f.n)
        plan_set_variant(&t->plan, device, plan_variant(&f.plans[leader], device));
    return true;
}

bool variants_share_of_a(tuning *t, uint32_t *share, duet_error *err)
{
    trial whole, part;
    duet_plan b_alone = tuning_plan(t, 0, DUET_MODE_OWN);
    duet_plan probe = tuning_plan(t, DUET_SHARE_ONE / 16, DUET_MODE_OWN);
    *share = probe.share;
    if (!tuning_run_trial(t, &b_alone, &whole, err) || !tuning_run_trial(t, &probe, &part, err))
        return false;
    if (whole.usable && part.usable && part.sample.a_ns > 0) {
        double fits = (double)whole.sample.total_ns / (double)part.sample.a_ns;
        *share = (uint32_t)(probe.share * fmin(fmax(fits, 1), 16));
    }
    return true;
}

// No verdict follows for a device that shares with none. So the winner of the quick race is used
// only if it is surely faster than the usual variant, if that is among those to try.
static bool confirm_variant(tuning *t, const char *usual, duet_error *err)
{
    if (!tune_has_variant(t->problem->def, usual) || strcmp(t->plan.variant_b, usual) == 0)
        return true;
    field f = {0};
    duet_plan plan = tuning_plan(t, 0, DUET_MODE_OWN);
    plan_set_variant(&plan, 1, usual);
    field_enter(&f, plan);
    field_enter(&f, tuning_plan(t, 0, DUET_MODE_OWN));
    t->stage_end = VERDICT_END;
    if (!field_race(t, &f, &trial_budget_last_race, false, INFINITY, err))
        return false;
    if (race_rounds(&f.race, 0, 1) == 0 || race_compare(&f.race, 1, 0).verdict != RACE_FASTER)
        plan_set_variant(&t->plan, 1, usual);
    return true;
}

bool variants_choose(tuning *t, duet_error *err)
{
    uint32_t share;
    const duet_plan usual = t->plan;
    for (int device = 0; device < 2; ++device)
        plan_set_variant(&t->plan, device, tune_variant(t->problem->def, 0));
    if (!tune_variant(t->problem->def, 1))
        return true;
    t->stage_end = VARIANTS_END;
    t->stage = "variant of B";
    if (!choose_variant(t, 1, 0, err))
        return false;
    if (t->problem->one_device) {
        if (!confirm_variant(t, usual.variant_b, err))
            return false;
        plan_set_variant(&t->plan, 0, t->plan.variant_b);
        return true;
    }
    t->stage = "variant of A";
    return variants_share_of_a(t, &share, err) && choose_variant(t, 0, share, err);
}
