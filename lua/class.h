// SPDX-License-Identifier: MIT
// A kind of userdata: methods, fields that read like a table's, and how it is
// closed. A closed one answers no method but close, which may come again.
#ifndef LUA_CLASS_H
#define LUA_CLASS_H

#include "lua/member.h"

#include "duet_error.h"

#include <lauxlib.h>
#include <lua.h>
#include <stdbool.h>

typedef struct lua_class {
    const char *name;                       // "duet.scene"
    const luaL_Reg *methods;                // "close" is __gc and __close too
    const luaL_Reg *more_methods;           // of another file; NULL: none
    const luaL_Reg *metas;                  // __len ...; NULL: none
    const member *members;                  // NULL: none
    const void *(*struct_of)(lua_State *L); // the struct of the userdata at 1; raises if closed
    lua_CFunction about; // of one without members: pushes what it is in words; raises if closed
} lua_class;

// Makes the metatable, once a state.
void class_open(lua_State *L, const lua_class *c);

// A Lua function: of an object of ours its class's name, then the names of its fields
// in order and those of its methods, as two lists; of anything else nothing.
int class_names(lua_State *L);

// Pushes a zeroed userdata with space for one uservalue: its parent.
void *class_push(lua_State *L, const lua_class *c, size_t bytes);

// nil, message, "STATUS": what a failed call gives back.
int class_push_failure(lua_State *L, const duet_error *err);
// Raises an error where the running script's time is over or it was told to
// stop: for functions that work long.
void class_check_limits(lua_State *L);

// true, or the failure.
int class_push_done(lua_State *L, bool ok, const duet_error *err);

#endif
