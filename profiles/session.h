// SPDX-License-Identifier: MIT
// A session: one search for one workload on one pair, how it is resumed, and its
// trials: one plan each, with every launch kept.
//
// A session that was killed or stopped is taken up again by the next process
// that wants the same; each trial is written with the search's state in one
// transaction, so a kill loses at most the trial that was being measured.
#ifndef PROFILES_SESSION_H
#define PROFILES_SESSION_H

#include "profiles/subject.h"

#define PROFILE_VARIANT 192

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
    text search_state; // JSON; empty if none was saved
    uint32_t trials;
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
void profile_resumed_free(profile_resumed *resumed);

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

// ---------------------------------------------------------------- trials

#define PROFILE_SHARE_ONE 65536

// How a step was done; mirrors the public plan, which this module does not know.
typedef struct profile_plan {
    uint32_t share;                  // A's part out of PROFILE_SHARE_ONE
    char mode[16];                   // "shared", "own" or "slab"
    char level[16];                  // the level of accuracy, "certified"
    char variant_a[PROFILE_VARIANT]; // "auto sort=radix"
    char variant_b[PROFILE_VARIANT];
} profile_plan;

typedef enum profile_sample_flag {
    PROFILE_SAMPLE_WARM_UP = 1,  // before the clock counts
    PROFILE_SAMPLE_OUTLIER = 2,  // marked, and kept
    PROFILE_SAMPLE_DISTURBED = 4 // other programs disturbed it, so that it does not count
} profile_sample_flag;

// One launch. Times that were not measured are 0.
typedef struct profile_sample {
    int64_t total_ns;
    int64_t a_ns;
    int64_t b_ns;
    int64_t transfer_ns;
    int64_t merge_ns;
    int64_t cpu_ns;  // processor time of the calling thread and of the busiest other one
    int64_t wait_ns; // the longest that a thread waited for a core
    uint32_t flags;
    int64_t at_ns; // when, by the calendar
} profile_sample;

typedef struct profile_trial {
    profile_plan plan;
    const char *outcome; // "ok", "build", "launch", "wrong", "timeout" or "pruned"
    const char *reason;  // one line if not ok; else NULL
    double build_ms;     // 0: nothing was built
    uint32_t outliers;
    uint32_t disturbed; // launches that count although other programs disturbed them
    double median_ns;   // the total's, as all below; NaN unless ok when read
    double mad_ns;      // median absolute deviation
    double low_ns;      // the median's interval
    double high_ns;
    double a_ns;       // median of A's part; 0: A had none
    double b_ns;       // and of B's
    const char *terms; // a JSON object: T_CPU1, T_GPU1, T_BUS1 ... (equations 4 to 6); NULL: none
    const profile_sample *samples;
    uint32_t n_samples;
} profile_trial;

// Adds a trial, its samples and, unless NULL, the search's state: all or
// nothing, and the owner is seen to live. `number` counts from 0 in its session.
bool profile_trial_add(store *s, const char *session, const profile_trial *trial,
                       const char *search_state, int64_t *number, duet_error *err);

// The number of the session's last trial of that plan that ran; -1: none did.
bool profile_trial_find(store *s, const char *session, const profile_plan *plan, int64_t *number,
                        duet_error *err);

// Called for each trial of a session in order; what trial points to is valid
// in the call. False stops the walk.
typedef bool profile_trial_visit(void *context, int64_t number, const profile_trial *trial);

bool profile_trial_each(store *s, const char *session, profile_trial_visit *visit, void *context,
                        duet_error *err);

#endif
