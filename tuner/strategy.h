// SPDX-License-Identifier: MIT
// How the next share is chosen. One file a strategy, one row in the table.
//
// Each function sees the search as it is and keeps nothing: what it decides
// follows from the samples alone, replayed from the first.
#ifndef TUNER_STRATEGY_H
#define TUNER_STRATEGY_H

#include "tuner/search.h"

struct strategy {
    const char *name;
    const char *about;
    bool evened;       // its share is evened out by what both devices take in the verdict
    uint32_t launches; // at most, where the options name no number; 0: no end of its own
    bool (*ask)(const search *s, search_next *next, duet_error *err);
    uint32_t (*pick)(const search *s);
    void (*bracket)(const search *s, uint32_t *low, uint32_t *high); // NULL: the whole range
};

extern const strategy *const strategies[]; // ends with NULL; the first is the default

const strategy *strategy_at(uint32_t i); // NULL past the end

const strategy *strategy_find(const char *name); // NULL where there is none

extern const strategy strategy_balance;
extern const strategy strategy_bisect;
extern const strategy strategy_chunks;
extern const strategy strategy_fig12;
extern const strategy strategy_golden;
extern const strategy strategy_grid;
extern const strategy strategy_lua;

// The pick of strategies that trust single samples: the fastest one's share.
uint32_t strategy_pick_fastest(const search *s);

#endif
