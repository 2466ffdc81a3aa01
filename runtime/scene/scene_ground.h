// SPDX-License-Identifier: MIT
// Fields that tables of grounds have in common, each of the table on top of the stack.
#ifndef RUNTIME_SCENE_GROUND_H
#define RUNTIME_SCENE_GROUND_H

#include <lua.h>
#include <stdbool.h>
#include <stdint.h>

// Whether the table has no other fields than these; NULL ends them.
bool ground_has_only(lua_State *L, const char *const names[]);

// Reads up to three numbers in a list, or one for all of them; `to` stays if there is no such
// field. False for anything else.
bool ground_read_numbers(lua_State *L, const char *name, double *to, int n);

bool ground_read_origin(lua_State *L, double to[3]);

// 0 if there is none.
bool ground_read_material(lua_State *L, uint32_t *to);

// 1 + the id that the field has, likewise.
bool ground_read_carrier(lua_State *L, uint32_t *to);

#endif
