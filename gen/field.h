// SPDX-License-Identifier: MIT
// Reads the fields of a table that a script returned, as a def is read.
//
// A field that is wrong or unknown is a Lua error with the script's file and,
// where that can be told, the line: so these belong in a C function called
// through script_call, right after the script ran. `table` is a stack index.
// A field that is nil takes the fallback.
#ifndef GEN_FIELD_H
#define GEN_FIELD_H

#include <lua.h>
#include <stdbool.h>
#include <stdint.h>

// Raises "file:line: WHAT has no field 'x': there are a, b, c" for a key that
// is not in names, which ends with NULL.
void field_only(lua_State *L, int table, const char *what, const char *const *names);

bool field_boolean(lua_State *L, int table, const char *name, bool fallback);
double field_number(lua_State *L, int table, const char *name, double fallback); // finite
int64_t field_integer(lua_State *L, int table, const char *name, int64_t fallback);
const char *field_string(lua_State *L, int table, const char *name, const char *fallback);

// Pushes the value if it is of that type (LUA_TTABLE, LUA_TFUNCTION); pushes
// nothing and is false if it is nil.
bool field_push(lua_State *L, int table, const char *name, int type);

// The line of the script that gives name a value; 0 if there is none, or more than one.
int field_line(lua_State *L, const char *name);

// Raises "file:line: message", the line being where the script gives name a
// value; NULL for a message about the whole file.
int field_raise(lua_State *L, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
