// SPDX-License-Identifier: MIT
// How kernels and share are chosen together: the table of strategies, like that of strategies for
// the share (strategy.h).
//
// Each function sees the history and keeps nothing: chance follows from the seed and the number of
// what is asked, so a search that is resumed goes on as if it had never stopped.
#ifndef TUNER_JOINT_STRATEGY_H
#define TUNER_JOINT_STRATEGY_H

#include "gen/script.h"
#include "tuner/joint_space.h"

typedef struct joint_sample {
    joint_point at;
    bool usable;         // it ran, and found what is right
    search_sample times; // total_ns is what is made small
} joint_sample;

typedef struct joint_history {
    const joint_space *space; // borrowed
    script *script;           // only strategy lua has it; borrowed
    uint64_t seed;
    uint32_t most; // samples there may be
    joint_sample *samples;
    uint32_t n;
    uint32_t capacity;
} joint_history;

bool joint_history_add(joint_history *h, const joint_sample *sample, duet_error *err);
void joint_history_free(joint_history *h);
const joint_sample *joint_history_find(const joint_history *h, const joint_point *at); // or NULL

typedef struct joint_next {
    bool done;
    joint_point at;
} joint_next;

typedef struct joint_strategy {
    const char *name;
    const char *about;
    bool all; // it asks for every plan; else a tenth of them, within bounds, is its own end
    bool (*ask)(const joint_history *h, joint_next *next, duet_error *err);
} joint_strategy;

extern const joint_strategy *const joint_strategies[]; // ends with NULL

const joint_strategy *joint_strategy_find(const char *name); // NULL if there is none

// The strategy "lua" if its script returns a table with a function `joint`:
//
//     return { joint = function(space, history)
//       if #history < 20 then return { share = 0.25, configs = { 1, 2 } } end
//     end }
//
// space has kernels ({ device =, name =, now =, configs = { { WG = 16, ... }, ... } }), shares (the
// grid), seed and most; a row of history share, configs (one for each kernel, from 1), total, a and
// b in ms, and ok. A share between those of the grid is taken too. nil ends the search.
extern const joint_strategy joint_strategy_lua;

// The strategy of a tuning, whose script is own or NULL; NULL if it searches the share by itself.
const joint_strategy *joint_strategy_of(const char *name, script *own);

// Samples that a strategy takes if nothing else ends it.
uint32_t joint_strategy_samples(const joint_strategy *of, const joint_space *space);

// BAD_ARGUMENT for a name that is neither a strategy for the share nor one of these.
bool joint_strategy_check(const char *name, duet_error *err);

#endif
