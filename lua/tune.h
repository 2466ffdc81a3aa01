// SPDX-License-Identifier: MIT
// Modes that a tuning and an online plan take.
#ifndef LUA_TUNE_H
#define LUA_TUNE_H

#include "duet_tune.h"
#include "lua/nouns.h"

// Finds modes by their names, and raises an error for an unknown one. Returns how many there are.
uint32_t tune_read_modes(lua_State *L, const field_name_list *names, duet_mode modes[32]);

#endif
