// SPDX-License-Identifier: MIT
// How many trials a tuning takes, and what part of its budget each stage may use.
#ifndef TUNER_TRIAL_BUDGET_H
#define TUNER_TRIAL_BUDGET_H

#include "tuner/race.h"
#include "tuner/tune.h"

enum {
    VERDICT_REPEATS = 2, // at most, of which the quicker is typical
    LEAST_RACED = 8,     // rounds from which a verdict has its confidence
};

// The part of the budget that is used up when a stage must end. The search ends sooner if a verdict
// takes more trials.
#define VARIANTS_END 0.35
#define KERNELS_END 0.55
#define SEARCH_END 0.7
#define VERDICT_END 0.9
#define ALL 1.0

extern const race_options trial_budget_quick_race; // the race of variants
extern const race_options trial_budget_last_race;  // the race for the verdict

// The fewest trials of a budget from which a verdict follows.
uint32_t trial_budget_least(const duet_tune_def *def);

// Returns the most trials of variants, search and verdict, beside `kernels` of the kernels' search.
uint32_t trial_budget_most(const tune_problem *problem, uint32_t kernels);

// Returns how many these are if races end as soon as they may.
uint32_t trial_budget_likely(const tune_problem *problem, uint32_t kernels);

// Trials at which the stage with that end must end, of a budget in trials.
double trial_budget_end(const tune_problem *problem, double stage_end);

#endif
