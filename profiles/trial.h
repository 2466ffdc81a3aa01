// SPDX-License-Identifier: MIT
// A trial: one plan of a session, with every launch kept.
#ifndef PROFILES_TRIAL_H
#define PROFILES_TRIAL_H

#include "profiles/store.h"

#define PROFILE_VARIANT 192
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
    uint64_t focus_ns; // a typical launch's in the stages whose kernel was varied; else 0
    uint64_t spent_ns; // on all of it by the clock, builds included
    int64_t scope; // how much of the work it did, of PROFILE_SHARE_ONE, which is usual; below 0:
                   // on the device that A and B are parts of, with B's variant
    const char *terms; // a JSON object: T_CPU1, T_GPU1, T_BUS1 ... (equations 4 to 6); NULL: none
    const profile_sample *samples;
    uint32_t n_samples;
} profile_trial;

// Adds the session's trial of that number, which counts from 0, and its samples: all or nothing,
// and the owner is seen to live. Stale trials from that number on go.
bool profile_trial_add(store *s, const char *session, int64_t number, const profile_trial *trial,
                       duet_error *err);

// Removes the session's trials from that number on.
bool profile_trial_drop(store *s, const char *session, int64_t from, duet_error *err);

// The number of the session's last trial of that plan that ran; -1: none did.
bool profile_trial_find(store *s, const char *session, const profile_plan *plan, int64_t *number,
                        duet_error *err);

// Called for each trial of a session in order; what trial points to is valid
// in the call. False stops the walk.
typedef bool profile_trial_visit(void *context, int64_t number, const profile_trial *trial);

bool profile_trial_each(store *s, const char *session, profile_trial_visit *visit, void *context,
                        duet_error *err);

#endif
