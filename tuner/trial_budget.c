// SPDX-License-Identifier: MIT
#include "tuner/trial_budget.h"

#include "tuner/strategy.h"

#include <math.h>

enum {
    LEAST_SEARCHED = 3, // trials of a mode
    PROBES = 1,         // of A alone, which say whether it races
};

const race_options trial_budget_quick_race = {
    .least_rounds = 4, .most_rounds = 6, .confidence = 0.85, .dropped = 1};

const race_options trial_budget_last_race = {.least_rounds = 14,
                                             .most_rounds = 40,
                                             .confidence = 0.99,
                                             .dropped = 1.03,
                                             .stay = 1, // the device alone
                                             .chosen_after = 14,
                                             .margin = 0.03};

bool trial_budget_has_parts(const tune_problem *problem)
{
    static const double long_ms = 100;
    const measure_machine *machine = &problem->machine;
    return machine->set_part && !problem->meter && machine->launch_ms >= long_ms;
}

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

static uint32_t rounds(race_options of, bool likely)
{
    return likely ? of.least_rounds : of.most_rounds;
}

// The trials of races that take as few rounds as they may, or as many.
static uint32_t count_trials(const tune_problem *problem, uint32_t kernels, bool likely)
{
    const duet_tune_def *def = problem->def;
    uint32_t variants = tune_count_variants(def), modes = tune_count_modes(def);
    uint32_t usual = rounds(race_default_options(), likely);
    const strategy *searches = strategy_find(def->strategy);
    uint32_t searched = searches ? searches->launches : 0;
    uint32_t n = kernels +
                 (variants > 1 ? 2 * variants * rounds(trial_budget_quick_race, likely) + 2 : 0) +
                 modes * searched + PROBES + most_rivals(def) * usual +
                 (problem->fair ? 5 : 3) * rounds(trial_budget_last_race, likely) +
                 (problem->whole.open ? 2 * usual : 0);
    return def->budget_trials > 0 && def->budget_trials < n ? def->budget_trials : n;
}

uint32_t trial_budget_most(const tune_problem *problem, uint32_t kernels)
{
    return count_trials(problem, kernels, false);
}

uint32_t trial_budget_likely(const tune_problem *problem, uint32_t kernels)
{
    return count_trials(problem, kernels, true);
}

// After all races of what is tuned: one with the undivided device, or an only device's steps, and
// all of the work by two plans.
static uint32_t least_at_the_end(const tune_problem *problem)
{
    uint32_t all = trial_budget_has_parts(problem) ? 2 : 0;
    return all + (problem->whole.open ? LEAST_RACED * 2 : problem->one_device ? LEAST_RACED : 0);
}

double trial_budget_end(const tune_problem *problem, double stage_end)
{
    const duet_tune_def *def = problem->def;
    double all = def->budget_trials;
    double raced = all - least_at_the_end(problem);
    double searched = fmin(SEARCH_END * raced, raced - PROBES - LEAST_RACED * most_rivals(def));
    if (stage_end <= SEARCH_END)
        return stage_end / SEARCH_END * searched;
    return stage_end < ALL ? raced : all;
}
