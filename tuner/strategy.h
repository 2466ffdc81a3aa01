// SPDX-License-Identifier: MIT
// How the next share is chosen, or the next share and kernels together: the table of strategies.
//
// Each function sees the search and keeps nothing: what it decides follows from the samples alone,
// replayed from the first. Chance follows from the seed and the number of what is asked.
#ifndef TUNER_STRATEGY_H
#define TUNER_STRATEGY_H

#include "gen/script.h"
#include "tuner/search.h"

// The choice that a strategy makes.
typedef enum strategy_choice {
    STRATEGY_SHARE,
    STRATEGY_JOINT,    // kernels and share together, a tenth of all plans within bounds
    STRATEGY_JOINT_ALL // the same, every plan
} strategy_choice;

typedef struct strategy {
    const char *name;
    const char *about;
    strategy_choice choice;
    bool evened;       // its share is evened out by what both devices take in the verdict
    uint32_t launches; // at most, if the options name no number; 0: no end of its own
    bool (*ask)(const search *h, search_next *next, duet_error *err);
    uint32_t (*pick)(const search *h);                               // NULL: no share alone
    void (*bracket)(const search *h, uint32_t *low, uint32_t *high); // NULL: all
} strategy;

// Ends with NULL; the first is the default, and those that choose a share alone come first.
extern const strategy *const strategies[];

const strategy *strategy_find(const char *name); // NULL if there is none

// BAD_ARGUMENT for a name that is none: the line lists those there are.
bool strategy_check(const char *name, duet_error *err);

// The strategy of a tuning whose script is own, or NULL.
const strategy *strategy_of(const char *name, script *own);

// Begins a search for the share. BAD_ARGUMENT for an unknown strategy: the line lists those there
// are. options NULL: the default ones.
bool search_begin(search *s, const char *strategy, const search_options *options, duet_error *err);

extern const strategy strategy_balance, strategy_random, strategy_annealing, strategy_brute;
extern const strategy strategy_lua, strategy_lua_joint;

// The script behind the strategy "lua".
//
// Its text returns a function from the history to the next share, or a table
// whose field "strategy" is one, as a tune file does:
//
//     return function(history)
//       local last = history[#history] -- {share =, total =, a =, b =}, times in ms
//       if #history < 5 then return #history / 4 end
//     end
//
// nil ends the search; the pick is the share of the least total. It must decide
// from the history alone, or a resumed search goes another way.
//
// A function in the field "joint" chooses kernels and share together:
//
//     return { joint = function(space, history)
//       if #history < 20 then return { share = 0.25, configs = { 1, 2 } } end
//     end }
//
// space has kernels ({ device =, name =, now =, configs = { { WG = 16, ... }, ... } }), shares (the
// grid), seed and most; a row of this history also configs (one for each kernel, from 1) and ok. A
// share between those of the grid is taken too.
//
// NULL with BAD_INPUT and name:line. Goes into search.script; closed by
// script_close.
script *strategy_lua_open(const char *name, const char *chars, duet_error *err);

// Whether the script's function is such a one.
bool strategy_lua_is_joint(script *s);

#endif
