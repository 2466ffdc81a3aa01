// SPDX-License-Identifier: MIT
// Strategies by their names, those of lua/experiments like the library's own.
#ifndef SUPPORT_ANY_STRATEGY_H
#define SUPPORT_ANY_STRATEGY_H

#include "tuner/strategy.h"

// All but "lua"; ends with NULL.
extern const char *const any_strategies[];

// Like search_begin and search_end, with the default options.
bool any_strategy_begin(search *s, const char *name, duet_error *err);
void any_strategy_end(search *s);

#endif
