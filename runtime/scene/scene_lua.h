// SPDX-License-Identifier: MIT
// A scene while its script runs, and what it says of motion: bodies of its objects, and a motion's
// def. Mistakes are raised as Lua errors; the reading's err keeps the status if a check of the
// scene's own refused an object.
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
    uint64_t expected; // objects, by the parameter n; 0: not known
    uint64_t seed;     // the parameter of that name; 0 where there is none
    uint64_t n_each;   // calls of each until now
    bool in_each;
} scene_reading;

// Words of a scene's script; upvalue 1 is the reading.
int scene_word_add(lua_State *L);    // add(row of numbers) and add{named parts}
int scene_word_each(lua_State *L);   // each(n, function(i, random) ... end)
int scene_word_euler(lua_State *L);  // euler(phi, theta, psi) -> x, y, z, w
int scene_word_random(lua_State *L); // random(seed)

// Adds the objects of the table at index 1.
void scene_read_objects(lua_State *L, scene_reading *reading);

// ---------------------------------------------------------------- scene_motion.c

// An object's body, as far as it is given; bits of the fields in their table.
typedef struct scene_body {
    uint32_t id;
    uint32_t given;
    duet_body body;
} scene_body;

// Reads the field `name` of an object from the top of the stack. False where
// bodies have no such field; the fields are named by SCENE_BODY_NAMES.
bool scene_read_body_field(lua_State *L, const char *name, scene_body *body);
#define SCENE_BODY_NAMES                                                        \
    "angular_velocity, fixed_rotation, friction, group, mask, mass, material, " \
    "restitution, rolling_resistance, sensor, surface_velocity, velocity"

// Keeps what was given for the object that was added last.
bool scene_keep_body(duet_scene *scene, const scene_body *body, duet_error *err);

// The scene's own fields of motion, each read from the table at index 1.
void scene_read_body(lua_State *L, scene_reading *reading);
void scene_read_heights(lua_State *L, scene_reading *reading);
void scene_read_mesh(lua_State *L, scene_reading *reading);
void scene_read_gravity(lua_State *L, scene_reading *reading);
void scene_read_origin(lua_State *L, scene_reading *reading);
void scene_read_attraction(lua_State *L, scene_reading *reading);
void scene_read_boundary(lua_State *L, scene_reading *reading);
void scene_read_wants(lua_State *L, scene_reading *reading);
void scene_read_integrator(lua_State *L, scene_reading *reading);
void scene_read_materials(lua_State *L, scene_reading *reading);

// Makes the bodies of all objects of what was given, after the last field.
bool scene_fill_bodies(duet_scene *scene, duet_error *err);

#endif
