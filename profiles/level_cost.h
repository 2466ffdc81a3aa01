// SPDX-License-Identifier: MIT
// Level costs: what each level of accuracy finds on a workload, and what a step takes at it.
#ifndef PROFILES_LEVEL_COST_H
#define PROFILES_LEVEL_COST_H

#include "profiles/store.h"

// The finds of a level, and the time of a step at it. A workload's table serves to
// choose a level within any budget, without measuring again.
enum { PROFILE_LEVEL_COSTS = 16 }; // the most levels of a list

typedef struct profile_level_cost {
    char level[16];
    double step_ns; // the median
    uint64_t true_pairs;
    uint64_t missed;   // pairs that it misses
    uint64_t invented; // pairs reported that are none
} profile_level_cost;

// The subject of a table of level costs. workload_id is that of level "auto".
typedef struct profile_level_cost_key {
    int64_t pair_id;
    int64_t workload_id;
    const char *kernels;
} profile_level_cost_key;

// Puts the list in the place of one that was there.
bool profile_level_costs_put(store *s, const profile_level_cost_key *key,
                             const profile_level_cost *costs, uint32_t n, duet_error *err);

// Fills costs [PROFILE_LEVEL_COSTS] by level; n is 0 if none are stored.
bool profile_level_costs_get(store *s, const profile_level_cost_key *key, profile_level_cost *costs,
                             uint32_t *n, duet_error *err);

#endif
