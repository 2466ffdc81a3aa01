// SPDX-License-Identifier: MIT
// What a scene's script works with while it runs: its words (add, euler,
// random, parameters) and the scene that they fill.
//
// The functions here that take a lua_State run under script_call and raise
// what is wrong as a Lua error; the reading's err keeps the status where a
// check of the scene's own refused an object.
#ifndef RUNTIME_SCENE_LUA_H
#define RUNTIME_SCENE_LUA_H

#include "runtime/scene/scene.h"

#include <lua.h>

typedef struct scene_reading {
    duet_scene *scene;
    const char *path;
    const duet_setting *settings;
    uint32_t n_settings;
    bool declared; // the script has declared its parameters
    duet_error *err;
} scene_reading;

// Adds the object on top of the stack, a table: a row of numbers or named parts.
void scene_add_table(lua_State *L, scene_reading *reading);

// Whether the keys of the table on top of the stack are 1, 2, ... n.
bool scene_is_list(lua_State *L);

// add(row of numbers) and add{named parts}; upvalue 1 is the reading.
int scene_word_add(lua_State *L);

// euler(phi, theta, psi) -> x, y, z, w
int scene_word_euler(lua_State *L);

// random(seed) -> a table of functions that draw from one source
int scene_word_random(lua_State *L);

// parameters{name = default, ...} -> the same with what was set from outside;
// upvalue 1 is the reading.
int scene_word_parameters(lua_State *L);

#endif
