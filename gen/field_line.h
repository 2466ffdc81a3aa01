// SPDX-License-Identifier: MIT
// Errors of Lua with the place that they are about: the line of the script that calls the C
// function or, if that has returned its table (script_call), the line that gives a field its value.
#ifndef GEN_FIELD_LINE_H
#define GEN_FIELD_LINE_H

#include <lua.h>

// The line of the script loaded last that gives name a value; 0 if there is none, or more than one.
int field_line(lua_State *L, const char *name);

// The line of the row, from 1, of a list that the script writes out, list = { { ... }, { ... } }:
// that which gives name a value in it, if exactly one does, or else its first. 0: there is no such
// list.
int field_line_in_row(lua_State *L, const char *list, lua_Integer row, const char *name);

// Raises "file:line: message". NULL for a message about the whole file.
int field_raise(lua_State *L, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// The same with the line; 0: not known.
int field_raise_at(lua_State *L, int line, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
