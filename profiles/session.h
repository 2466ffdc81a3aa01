// SPDX-License-Identifier: MIT
// A session: one search for one workload on one pair, and how it is resumed.
//
// A session that was killed or stopped is taken up again by the next process
// that wants the same, which goes on from its trials: each is written in one
// transaction, so a kill loses at most the trial that was being measured.
#ifndef PROFILES_SESSION_H
#define PROFILES_SESSION_H

#include "profiles/subject.h"
#include "profiles/trial.h"

typedef struct profile_session {
    int64_t pair_id;
    int64_t workload_id;
    const char *kernels;   // sha256 of all kernel text that the workload needs
    const char *strategy;  // "balance"
    const char *objective; // "time"
    const char *options;   // a JSON object: budget and what else decides the result; NULL: {}
    uint64_t seed;
    const char *script;       // text of the tune.lua; NULL: none
    const char *tool_version; // "0.9.0"
    double load;              // the machine's at the start, by its run queue
    double timer_ns;          // resolution of the clock that measured
} profile_session;

typedef enum profile_claim {
    PROFILE_CLAIM_NONE,    // nothing to take up
    PROFILE_CLAIM_RESUMED, // it is ours: measure on
    PROFILE_CLAIM_BUSY     // a living process has it
} profile_claim;

typedef struct profile_resumed {
    profile_claim claim;
    char id[PROFILE_ID];
    int64_t pid; // its owner, where BUSY
} profile_resumed;

// Starts a session, this process being its owner.
bool profile_session_begin(store *s, const profile_session *session, char id[PROFILE_ID],
                           duet_error *err);

// The profile that the latest complete session of the same question left, live or
// not: of the same pair, workload, kernels, strategy, objective, options and seed,
// and for strategy "lua" of the same script. uid is empty if there is none.
bool profile_session_known(store *s, const profile_session *session, char uid[PROFILE_ID],
                           duet_error *err);

// Takes up the latest unfinished session of the same question if its owner has
// gone. BUSY while a living process measures the workload, whatever its question,
// on this machine or on this pair.
bool profile_session_resume(store *s, const profile_session *session, profile_resumed *resumed,
                            duet_error *err);

// Shows that the owner lives.
bool profile_session_beat(store *s, const char *id, duet_error *err);

// how: "complete", "stopped" (to be resumed) or "failed". A complete session's
// trials enter the fits of its devices.
bool profile_session_end(store *s, const char *id, const char *how, duet_error *err);

// A search of kernels for a device of a pair, 0 being A.
typedef struct profile_search {
    int64_t pair_id;
    int device;
    int64_t workload_id;
    const char *kernels;
    const char *what; // the option "search" of its session
} profile_search;

// The variant in the latest profile that such a search led to, live or not, be the device's
// partner another one; empty if there is none.
bool profile_searched_variant(store *s, const profile_search *search, char variant[PROFILE_VARIANT],
                              duet_error *err);

#endif
