// SPDX-License-Identifier: MIT
// What a script lets be set from outside: parameters{n = 1000, seed = 1}.
//
// The default also says of which type a value must be, so that a mistyped setting is refused
// before it makes something else. The table of defaults is at index 1.
#ifndef GEN_PARAMETERS_H
#define GEN_PARAMETERS_H

#include <lua.h>

// Raises an error unless defaults are numbers, booleans and strings under string keys.
void parameters_check(lua_State *L);

// Sets one from its text. whose: "the scene", for messages.
void parameters_set(lua_State *L, const char *whose, const char *name, const char *value);

#endif
