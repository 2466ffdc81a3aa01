// SPDX-License-Identifier: MIT
// What a tuning measured, in order: all the state it has.
//
// A tuning decides from its measurements alone. One that was interrupted runs
// again from its beginning and is served what the store holds of it until that
// ends; then it measures on. So it ends as if it had never stopped.
#ifndef TUNER_TRIAL_LOG_H
#define TUNER_TRIAL_LOG_H

#include "tuner/duet_tune.h"
#include "tuner/search.h"

typedef struct trial {
    duet_plan plan;
    int32_t scope;         // how much of the work it did, of DUET_SHARE_ONE; below 0: on the
                           // undivided device
    bool usable;           // it built, ran and found the right pairs
    search_sample sample;  // its typical launch
    uint64_t focus_ns;     // that launch's time in the stages whose kernel was varied; else 0
    duet_tune_terms terms; // that launch's
    uint32_t launches;
    uint32_t watched;   // launches whose threads were watched
    uint32_t disturbed; // watched launches that waited for a core
    uint64_t spent_ns;  // by the clock, builds included
} trial;

typedef struct trial_log {
    trial *entries;
    uint32_t n;
    uint32_t played; // entries that were served again
} trial_log;

void trial_log_free(trial_log *t);
bool trial_log_add(trial_log *t, const trial *entry, duet_error *err);

bool trial_log_same_plan(const duet_plan *a, const duet_plan *b);

// The next entry to serve, if it is for this plan; NULL at the end. If it is for another plan,
// something that decides has changed: the rest is forgotten.
const trial *trial_log_next(trial_log *t, const duet_plan *plan, int32_t scope);

// The first trial so far, or the first after `after`, that measured the plan on that much of the
// work; NULL: there is none.
const trial *trial_log_of(const trial_log *t, const duet_plan *plan, int32_t scope,
                          const trial *after);

#endif
