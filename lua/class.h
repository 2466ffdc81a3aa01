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

// One of several methods that share a C function: `which` is its first upvalue.
typedef struct lua_shared {
    const char *name;
    lua_CFunction call;
    lua_Integer which;
} lua_shared;

typedef struct lua_class {
    const char *name;                       // "duet.scene"
    const luaL_Reg *methods;                // "close" is __gc and __close too
    const lua_shared *shared;               // methods too; NULL: none
    const luaL_Reg *metas;                  // __len ...; NULL: none
    const member *members;                  // NULL: none
    const void *(*struct_of)(lua_State *L); // the struct of the userdata at 1; raises if closed
    lua_CFunction about;           // without members: pushes what it is in words; raises if closed
    void (*destroy)(void *object); // "close", if the userdata begins with a handle
    const char *noun;              // the name of that: "tree"
} lua_class;

// The object of such a userdata. NULL: it is closed.
typedef struct lua_handle {
    void *object;
} lua_handle;

// Makes the metatable, once a state.
void class_open(lua_State *L, const lua_class *c);

// Adds methods to an open class, by its name, as they are in a lua_class: for the files
// whose objects are made of that class's. NULL: none.
void class_add_methods(lua_State *L, const char *name, const luaL_Reg *methods,
                       const lua_shared *shared);

// A Lua function: of an object of ours its class's name, then the names of its fields
// in order and those of its methods, as two lists; of anything else nothing.
int class_names(lua_State *L);

// Pushes a zeroed userdata with space for one uservalue: its parent.
void *class_push(lua_State *L, const lua_class *c, size_t bytes);

// The same, and the parent is the value at that index.
void *class_push_of(lua_State *L, const lua_class *c, size_t bytes, int parent_index);

// The userdata of such a class at an index, or the object of its handle. Both raise an error if
// it is closed.
void *class_check(lua_State *L, int index, const lua_class *c);
void *class_object(lua_State *L, int index, const lua_class *c);

// nil, message, "STATUS": what a failed call gives back.
int class_push_failure(lua_State *L, const duet_error *err);
// Raises an error if the running script's time is over or it was told to
// stop: for functions that work long.
void class_check_limits(lua_State *L);

// true, or the failure.
int class_push_done(lua_State *L, bool ok, const duet_error *err);

#endif
