// SPDX-License-Identifier: MIT
// A profile: the plan that a search chose, with what it is worth and why.
#ifndef PROFILES_PROFILE_H
#define PROFILES_PROFILE_H

#include "profiles/trial.h"
#include "profiles/workload.h"

typedef struct profile_row {
    int64_t pair_id;
    int64_t workload_id;
    const char *kernels;   // as in the session
    const char *objective; // "time"
    profile_plan plan;
    double median_ns; // a step by this plan
    double low_ns;    // the median's interval
    double high_ns;
    double gain; // over the best single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    const char *verdict;   // "faster", "same", "slower" than the best single device, or "ambiguous"
    double missed_rate;    // pairs missed, by true pairs, as measured; 0: none
    double false_rate;     // pairs reported in excess, by true pairs
    int64_t true_pairs;    // that the rates are of; -1: they were not measured
    double single_ns;      // a step by the best single device; 0: not known
    uint32_t best_share;   // of the best plan that shares the work, which the gain is of
    const char *best_mode; // NULL: the plan is that one
    const char *terms;     // of the best plan, a JSON object as a trial's; NULL: not known
    const char *origin;    // "measured", "online" or "manual"
    const char *session;   // NULL only for "manual"
    int64_t trial_number;  // of that session, the plan's trial; -1: none
} profile_row;

// Makes it the live profile of its pair, workload, kernels, objective and
// level. One that was live stays in the store, dead for `reason`.
bool profile_put(store *s, const profile_row *row, const char *reason, duet_error *err);

#endif
