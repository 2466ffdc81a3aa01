// SPDX-License-Identifier: MIT
#include "tuner/trial_budget.h"

#include "tuner/strategy.h"

#include <math.h>

enum { LEAST_SEARCHED = 3 }; // trials of a mode

const race_options trial_budget_quick_race = {
    .least_rounds = 4, .most_rounds = 6, .confidence = 0.85, .dropped = 1};

const race_options trial_budget_last_race = {.least_rounds = 14,
                                             .most_rounds = 40,
                                             .confidence = 0.99,
                                             .dropped = 1.03,
                                             .stay = 1, // the device alone
                                             .chosen_after = 14,
                                             .margin = 0.03};

// Counts the rivals of the first race: all devices alone, and each mode's best share.
static uint32_t most_rivals(const duet_tune_def *def)
{
    return 2 + tune_count_modes(def);
}

uint32_t trial_budget_least(const duet_tune_def *def)
{
    uint32_t variants = tune_count_variants(def);
    return (variants > 1 ? 2 * variants + 2 : 0) + LEAST_SEARCHED * tune_count_modes(def) +
           LEAST_RACED * most_rivals(def) + LEAST_RACED * 2;
}

uint32_t trial_budget_most(const tune_problem *problem, uint32_t kernels)
{
    const duet_tune_def *def = problem->def;
    uint32_t variants = tune_count_variants(def), modes = tune_count_modes(def);
    const strategy *searches = strategy_find(def->strategy);
    uint32_t searched = searches ? searches->launches : 0;
    uint32_t most = kernels +
                    (variants > 1 ? 2 * variants * trial_budget_quick_race.most_rounds + 2 : 0) +
                    modes * searched + most_rivals(def) * race_default_options().most_rounds +
                    (problem->fair ? 5 : 3) * trial_budget_last_race.most_rounds +
                    (problem->whole.open ? 2 * race_default_options().most_rounds : 0);
    return def->budget_trials > 0 && def->budget_trials < most ? def->budget_trials : most;
}

// After all races of what is tuned: one with the undivided device, or an only device's steps.
static uint32_t least_at_the_end(const tune_problem *problem)
{
    return problem->whole.open ? LEAST_RACED * 2 : problem->one_device ? LEAST_RACED : 0;
}

double trial_budget_end(const tune_problem *problem, double stage_end)
{
    const duet_tune_def *def = problem->def;
    double all = def->budget_trials;
    double raced = all - least_at_the_end(problem);
    double searched = fmin(SEARCH_END * raced, raced - LEAST_RACED * most_rivals(def));
    if (stage_end <= SEARCH_END)
        return stage_end / SEARCH_END * searched;
    return stage_end < ALL ? raced : all;
}
