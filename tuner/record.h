// SPDX-License-Identifier: MIT
// A tuning's way into the profile store: its session, trials and profile.
#ifndef TUNER_RECORD_H
#define TUNER_RECORD_H

#include "profiles/level_cost.h"
#include "profiles/lookup.h"
#include "profiles/profile.h"
#include "tuner/race.h"
#include "tuner/tune.h"

typedef struct record {
    store *store;
    profile_request request; // which devices, workload and kernels
    char session[PROFILE_ID];
    int64_t pair_id;
    int64_t workload_id;
} record;

// Opens the store (path NULL: the user's) for writing. STORE_FAILED if it cannot be written, with
// what the store says of it.
bool record_open(record *r, const char *path, duet_error *err);

// Sets the workload that all later calls are about; it may change after each session.
bool record_aim(record *r, const profile_request *request, duet_error *err);
void record_close(record *r);

// The key of the table of level costs of that workload.
profile_level_cost_key record_cost_key(const record *r);

// Finds what a session that asked the same has found before, live or not; its grade is default if
// none has.
bool record_known(record *r, const duet_tune_def *def, profile_found *found, duet_error *err);

// Tells what it found as the outcome that the session had.
bool record_tell(const profile_found *found, duet_tune_outcome *outcome, duet_error *err);

// Takes up an interrupted session of the same tuning, whose log is then filled, or begins one.
// STORE_FAILED if a living process tunes the workload.
bool record_begin(record *r, const duet_tune_def *def, trial_log *state, bool *resumed,
                  duet_error *err);

tune_recorder record_recorder(record *r);

// Fills the log with the trials that the session has.
bool record_recall(const record *r, trial_log *state, duet_error *err);

// how: "complete", "stopped" or "failed". A complete one leaves its profile, and the
// outcome says where.
bool record_end(record *r, const char *how, const duet_tune_def *def, duet_tune_outcome *outcome,
                duet_error *err);

// Keeps the plan of the winner of a race, whose gain is over `other`, as a session of its own.
bool record_raced(record *r, const duet_plan *plan, const race *ran, uint32_t winner,
                  uint32_t other, duet_error *err);

// Keeps a plan that was found while an application ran.
bool record_online(record *r, const duet_plan *plan, double step_ns, duet_error *err);

#endif
