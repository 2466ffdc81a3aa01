// SPDX-License-Identifier: MIT
// What the fits of two devices predict of a workload that they never did together.
#ifndef PROFILES_FORECAST_H
#define PROFILES_FORECAST_H

#include "profiles/fit.h"
#include "profiles/lookup.h"

// A question to the fits of two devices, about a workload that they never did
// together, or not at that size.
typedef struct forecast_ask {
    const char *env_a; // keys
    const char *env_b;
    const char *family;
    const char *kernels;
    const char *host;
    double n;
    double occupancy;
} forecast_ask;

typedef struct forecast {
    profile_plan plan; // without its share
    bool here;         // measured on the host asked for
    double share;      // A's part where both end together, 0 to 1
    double share_sd;
    fit_time both; // at that share
    double doubt;  // its relative standard deviation
    fit_time alone[2];
    bool a_is_best; // A is the faster one of the two alone
    double n_min;   // sizes measured
    double n_max;
    uint32_t points;
} forecast;

// The quickest plan, what was measured on the host asked for before others.
// Both devices' fits are always of one machine.
bool forecast_best(store *s, const forecast_ask *ask, forecast *best, bool *found, duet_error *err);

// The plan that follows from it, if sharing or one of the devices is surely the fastest, by two
// standard deviations; else false, and found stays. It has no figures.
bool forecast_take(const forecast *f, profile_found *found);

#endif
