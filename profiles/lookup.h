// SPDX-License-Identifier: MIT
// Which plan an application gets, and how good the grounds for it are.
//
// The ladder goes from what was measured here to what is a guess, and the
// grade says where it ended. No row of other devices is ever handed out as if
// it were these devices' own.
#ifndef PROFILES_LOOKUP_H
#define PROFILES_LOOKUP_H

#include "profiles/profile.h"

// Best first.
typedef enum profile_grade {
    PROFILE_EXACT,        // measured on these devices, drivers, kernels and workload
    PROFILE_OTHER_DRIVER, // the same, under another version of a driver
    PROFILE_INTERPOLATED, // of this pair: next to a size measured, or between by time fits
    PROFILE_TRANSFERRED,  // from each device's fits: never measured together, or beyond the sizes
    PROFILE_STALE,        // the kernels changed since: only a place to start a search from
    PROFILE_DEFAULT       // nothing is known; the plan is not set
} profile_grade;

const char *profile_grade_name(profile_grade grade); // "exact", "other driver", ...

typedef struct profile_request {
    const profile_pair *pair;
    const profile_workload *workload;
    const char *kernels;
    const char *objective;
    double max_missed_rate; // accuracy asked for; a profile that gave less is passed over
    double max_false_rate;
    char host[PROFILE_SHA]; // fits of this machine come before those of others
} profile_request;

// Objective "time", no limit on rates, this host.
profile_request profile_default_request(void);

typedef struct profile_found {
    profile_grade grade;
    profile_plan plan;
    uint32_t share_low; // where the best share may lie: equal to the share where it was measured
    uint32_t share_high;
    double median_ns; // of a step; predicted where not measured
    double gain;      // over the best single device
    double gain_low;
    double gain_high;
    char verdict[16];
    int64_t created_ns; // calendar; 0 where predicted
    char session[PROFILE_ID];
    char uid[PROFILE_ID]; // of the profile; empty where predicted
} profile_found;

// Looks in one store. found is always filled; why, unless NULL, takes one line
// a rung of the ladder, with the reason why it did or did not hold.
bool profile_lookup(store *s, const profile_request *request, profile_found *found, text *why,
                    duet_error *err);

// What an application does at its start: looks in the user's file and, where
// that has nothing better, in the system's; neither is written, made, or
// waited for. A missing file is no failure. On any failure found has the best
// that the other file gave, or the default grade.
bool profile_lookup_files(const char *user_path, const char *system_path,
                          const profile_request *request, profile_found *found, text *why,
                          duet_error *err);

#endif
