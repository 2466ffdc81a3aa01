// SPDX-License-Identifier: MIT
// How the next share is chosen: the table of strategies.
//
// Each function sees the history and keeps nothing: what it decides follows
// from the samples alone, replayed from the first.
#ifndef TUNER_STRATEGY_H
#define TUNER_STRATEGY_H

#include "gen/script.h"
#include "tuner/search_history.h"

// Says which launch a strategy wants next, or none.
typedef struct search_next {
    bool done;
    uint32_t share;
} search_next;

typedef struct strategy {
    const char *name;
    const char *about;
    bool evened;       // its share is evened out by what both devices take in the verdict
    uint32_t launches; // at most, if the options name no number; 0: no end of its own
    bool (*ask)(const search_history *h, search_next *next, duet_error *err);
    uint32_t (*pick)(const search_history *h);
    void (*bracket)(const search_history *h, uint32_t *low, uint32_t *high); // NULL: all
} strategy;

extern const strategy *const strategies[]; // ends with NULL; the first is the default

const strategy *strategy_at(uint32_t i); // NULL past the end

const strategy *strategy_find(const char *name); // NULL if there is none

extern const strategy strategy_balance;
extern const strategy strategy_lua;

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
// NULL with BAD_INPUT and name:line. Goes into search_history.script; closed by
// script_close.
script *strategy_lua_open(const char *name, const char *chars, duet_error *err);

// Whether the script's function chooses kernels and share together (joint_strategy.h).
bool strategy_lua_is_joint(script *s);

// Calls `call` with the script's function, history and next on its stack.
bool strategy_lua_call(script *s, int (*call)(lua_State *L), const void *history, void *next,
                       duet_error *err);

#endif
