// SPDX-License-Identifier: MIT
// Whether steps take other times than the profile says: EWMA and CUSUM of the
// log of measured by expected time.
#ifndef PROFILES_DRIFT_H
#define PROFILES_DRIFT_H

#include "profiles/store.h"

typedef struct profile_drift {
    uint64_t n;
    double mean;     // EWMA of ln(measured / expected)
    double variance; // EWMA of its square about the mean
    double up;       // CUSUM, in standard deviations
    double down;
} profile_drift;

// Adds one step. True where the times have shifted: the caller tunes again and
// starts from a zeroed drift. Needs no store and allocates nothing.
bool profile_drift_update(profile_drift *drift, double measured_ns, double expected_ns);

// Kept beside a profile, named by its uid; zeroed where none was kept.
bool profile_drift_save(store *s, const char *uid, const profile_drift *drift, duet_error *err);
bool profile_drift_load(store *s, const char *uid, profile_drift *drift, duet_error *err);

#endif
