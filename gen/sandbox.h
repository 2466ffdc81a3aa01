// SPDX-License-Identifier: MIT
// What a script finds in its state.
#ifndef GEN_SANDBOX_H
#define GEN_SANDBOX_H

#include <lua.h>

// What messages call the part of the sandbox that is written in Lua.
#define SANDBOX_PART "gen/sandbox.lua"

// A lua_CFunction: fills the globals of a fresh state of script.c.
int sandbox_open(lua_State *L);

#endif
