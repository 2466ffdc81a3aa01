// SPDX-License-Identifier: MIT
// Parameters of a script, which can be set from outside: parameters{n = 1000, seed = 1}.
//
// The default also says of which type a value must be, so that a mistyped setting is refused
// before it makes something else. The table of defaults is at index 1.
#ifndef GEN_PARAMETERS_H
#define GEN_PARAMETERS_H

#include <lua.h>
#include <stdbool.h>
#include <stdint.h>

// Begins the call of `parameters`. Raises an error if the script made one before, which *declared
// keeps, and unless defaults are numbers, booleans and strings under string keys.
void parameters_declare(lua_State *L, bool *declared);

// Sets one from its text; an error is the caller's BAD_ARGUMENT. whose: "the scene", for messages.
void parameters_set(lua_State *L, const char *whose, const char *name, const char *value);

// Ends the call: leaves the table alone on the stack, and returns its seed; 0: it has none.
uint64_t parameters_seed(lua_State *L);

#endif
