// SPDX-License-Identifier: MIT
// What the fits of two devices say about a workload that they never did
// together, or not at that size. Internal to this module.
#ifndef PROFILES_FORECAST_H
#define PROFILES_FORECAST_H

#include "profiles/fit.h"
#include "profiles/lookup.h"

typedef struct forecast_ask {
    const char *env_a; // keys
    const char *env_b;
    const char *family;
    const char *kernels;
    const char *host;
    double n;
    double occupancy;
    const profile_plan *plan; // its mode, level and variants only; NULL: any
} forecast_ask;

typedef struct forecast {
    profile_plan plan; // without its share
    bool here;         // measured on the host asked for
    double share;      // A's part where both end together, 0 to 1
    double share_sd;
    fit_time both; // at that share
    double doubt;  // of it, relative, one standard deviation
    fit_time one;  // by the better single device
    bool a_is_best;
    double n_min; // sizes measured
    double n_max;
    uint32_t points;
} forecast;

// The quickest plan, what was measured on the host asked for before others.
// Both devices' fits are always of one machine.
bool forecast_best(store *s, const forecast_ask *ask, forecast *best, bool *found, duet_error *err);

// The plan that follows from it. A gain that might be none is not taken: the
// better single device does all the work.
void forecast_take(const forecast *f, profile_found *found);

#endif
