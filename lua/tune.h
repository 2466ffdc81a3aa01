// SPDX-License-Identifier: MIT
// Lists of names that a tuning and an online plan take.
#ifndef LUA_TUNE_H
#define LUA_TUNE_H

#include "duet_tune.h"
#include "lua/nouns.h"

// A list of names in a table, kept alive by it; { "auto", "paper" }.
typedef struct name_list {
    const char *names[32];
    uint32_t n;
} name_list;

extern const member_type member_names; // a name_list
// Finds modes by their names, and raises an error for an unknown one. Returns how many there are.
uint32_t tune_read_modes(lua_State *L, const name_list *names, duet_mode modes[32]);

#endif
