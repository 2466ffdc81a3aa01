// SPDX-License-Identifier: MIT
// Duet from Lua 5.4: `require "duet"` calls luaopen_duet in duet.so; a program
// with a Lua state of its own calls it through luaL_requiref. docs/lua.md is
// the guide, lua/api.lua the list of all names.
#ifndef DUET_LUA_H
#define DUET_LUA_H

#include "duet_error.h"

DUET_C_BEGIN

struct lua_State;

// Leaves the module's table on the stack. Returns 0 and does nothing for NULL, as the calls below.
DUET_API int luaopen_duet(struct lua_State *L);

// require "duet.frame": rows in named columns; "duet.plot": pictures by
// gnuplot; "duet.timeline": a step's time lines; "duet.lab": what experiments share. luaopen_duet
// makes them known.
DUET_API int luaopen_duet_frame(struct lua_State *L);
DUET_API int luaopen_duet_lab(struct lua_State *L);
DUET_API int luaopen_duet_plot(struct lua_State *L);
DUET_API int luaopen_duet_timeline(struct lua_State *L);

DUET_C_END

#endif
