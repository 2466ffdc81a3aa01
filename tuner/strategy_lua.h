// SPDX-License-Identifier: MIT
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
#ifndef TUNER_STRATEGY_LUA_H
#define TUNER_STRATEGY_LUA_H

#include "gen/script.h"

// NULL with BAD_INPUT and name:line. Goes into search.script; closed by
// script_close.
script *strategy_lua_open(const char *name, const char *chars, duet_error *err);

#endif
