// SPDX-License-Identifier: MIT
// Plans that race against each other in trials of a tuning.
#ifndef TUNER_FIELD_H
#define TUNER_FIELD_H

#include "tuner/race.h"
#include "tuner/tuning.h"

// With the terms of each plan's last trial.
typedef struct field {
    duet_plan plans[RACE_RIVALS];
    duet_tune_terms terms[RACE_RIVALS];
    uint32_t n;
    bool of_a;       // A's own time counts, for its variant is chosen
    double hopeless; // a plan that takes so many times the leader's time runs no more; 0: each does
    const measure_machine *whole; // on which the last plan runs; NULL: it runs as the others
    race race;
} field;

// Beyond RACE_RIVALS none enters.
void field_enter(field *f, duet_plan plan);
void field_enter_new(field *f, const duet_plan *plan); // unless it is there

// Returns the index of the plan; f->n if it is not there.
uint32_t field_find(const field *f, const duet_plan *plan);

// Races until it is decided or the stage's part of the budget is spent. A trial's time is the time
// of the stages in focus or else the total or A's own. options NULL: the default ones.
void field_race(tuning *t, field *f, const race_options *options);

// Races a plan against the usual one, and tells its gain: AMBIGUOUS if one of them did not run.
race_gain field_duel(tuning *t, const duet_plan *usual, const duet_plan *plan,
                     const race_options *options);

#endif
