// SPDX-License-Identifier: MIT
// The price list of a workload: what each level of accuracy finds, and what a
// step takes at it. From it a level is chosen within a budget, any budget,
// without measuring again.
#ifndef PROFILES_PRICE_H
#define PROFILES_PRICE_H

#include "profiles/profile.h"

enum { PROFILE_PRICES = 16 }; // the most levels of a list

typedef struct profile_price {
    char level[16];
    double step_ns; // the median
    uint64_t true_pairs;
    uint64_t missed;   // of them
    uint64_t invented; // pairs reported that are none
} profile_price;

// What a price list is of. workload_id is that of level "auto".
typedef struct profile_price_key {
    int64_t pair_id;
    int64_t workload_id;
    const char *kernels;
} profile_price_key;

// Puts the list in the place of one that was there.
bool profile_prices_put(store *s, const profile_price_key *key, const profile_price *prices,
                        uint32_t n, duet_error *err);

// Fills prices [PROFILE_PRICES] by level; n is 0 where none are stored.
bool profile_prices_get(store *s, const profile_price_key *key, profile_price *prices, uint32_t *n,
                        duet_error *err);

#endif
