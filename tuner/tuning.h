// SPDX-License-Identifier: MIT
// A tuning under way: trials, from the log or from the machine, and races
// between plans.
#ifndef TUNER_TUNING_H
#define TUNER_TUNING_H

#include "tuner/race.h"
#include "tuner/tune.h"

typedef struct tuning {
    const tune_task *task;
    trial_log *state;
    const char *stage;
    double stage_end; // part of the budget that is used up when it must end
    uint32_t repeats; // launches of a trial that count
    duet_plan plan;   // the variants chosen so far
    uint32_t launches;
    uint64_t spent_ns;
    bool cut;           // the budget ended a search
    duet_error failure; // of the first plan that did not run
} tuning;

// What a trial gave to decide from.
typedef struct trial {
    bool usable;
    search_sample sample;
    duet_tune_terms terms;
} trial;

tuning tuning_begin(const tune_task *task, trial_log *state);

// The chosen variants at a share.
duet_plan tuning_plan_at(const tuning *t, uint32_t share, duet_mode mode);

bool tuning_within_budget(const tuning *t); // of the stage

bool tuning_run_trial(tuning *t, const duet_plan *plan, trial *out, duet_error *err);

// Plans in a race, with the terms of each one's last trial.
typedef struct field {
    duet_plan plans[RACE_RIVALS];
    duet_tune_terms terms[RACE_RIVALS];
    uint32_t n;
    race race;
} field;

void field_enter(field *f, duet_plan plan);

// Races until it is decided or the stage's part of the budget is spent. A
// trial's time is the total, or A's own where that is what is chosen. Where it
// is to be quick, who takes twice the leader's time runs no more.
bool tuning_race(tuning *t, field *f, const race_options *options, bool of_a, bool quick,
                 duet_error *err);

#endif
