// SPDX-License-Identifier: MIT
// Keeping a store in order: pruning and checking.
#ifndef PROFILES_UPKEEP_H
#define PROFILES_UPKEEP_H

#include "profiles/store.h"

typedef struct profile_prune_def {
    uint32_t keep_samples; // of each trial, spread evenly; medians and intervals stay
    int64_t before_ns;     // thins only what is older; calendar; INT64_MAX: all
    bool drop_dead;        // forgets profiles that were replaced
} profile_prune_def;

typedef struct profile_prune_counts {
    uint64_t samples;
    uint64_t profiles;
    int64_t bytes; // by which the file became smaller
} profile_prune_counts;

bool profile_prune(store *s, const profile_prune_def *def, profile_prune_counts *counts,
                   duet_error *err);

// One line in `report` for each thing that is wrong; true with no line if
// all is well.
bool profile_check(store *s, text *report, uint32_t *problems, duet_error *err);

#endif
