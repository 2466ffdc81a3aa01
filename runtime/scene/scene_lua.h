// SPDX-License-Identifier: MIT
// A scene while its script runs, and what it says of motion: bodies of its objects, and a motion's
// def. Mistakes are raised as Lua errors; the reading's err keeps the status if a check of the
// scene's own refused an object.
#ifndef RUNTIME_SCENE_LUA_H
#define RUNTIME_SCENE_LUA_H

#include "gen/field.h"
#include "runtime/scene/scene.h"

#include <float.h>
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
    double origin_edge;
} scene_reading;

// The reading, while the fields of a scene's table are read: the table is at index 1, this at 2.
scene_reading *scene_reading_of(lua_State *L);

// A field of the scene with a reader of its own, which is given the duet_scene.
#define SCENE_FIELD(name_, reader)                   \
    {                                                \
        .name = (name_), .type = &(const field_type) \
        {                                            \
            .read = (reader)                         \
        }                                            \
    }

// Words of a scene's script; upvalue 1 is the reading.
int scene_word_add(lua_State *L);    // add(row of numbers) and add{named parts}
int scene_word_each(lua_State *L);   // each(n, function(i, random) ... end)
int scene_word_euler(lua_State *L);  // euler(phi, theta, psi) -> x, y, z, w
int scene_word_random(lua_State *L); // random(seed)

void scene_read_objects(lua_State *L, const field *f, void *scene);

// ---------------------------------------------------------------- scene_motion.c

// An object's body, as far as it is given; bits of the rows of SCENE_BODY_FIELDS.
typedef struct scene_body {
    uint32_t id;
    uint32_t given;
    duet_body body;
} scene_body;

// The fields of a body.
// clang-format off
#define SCENE_BODY_FIELDS(struct_, path)                                         \
    FIELDS_FINITE(struct_, path, velocity),                                      \
    FIELD_IN(field_angular_velocity, struct_, path, angular_velocity),           \
    FIELDS_FINITE(struct_, path, mass, restitution, friction),                   \
    FIELDS_IN(struct_, path, group, mask, fixed_rotation, sensor),               \
    FIELDS_FINITE(struct_, path, rolling_resistance, surface_velocity),          \
    FIELDS_IN(struct_, path, material)
// clang-format on

// Three numbers; in 2D one.
extern const field_type field_angular_velocity;

// Keeps what was given for the object that was added last.
bool scene_keep_body(duet_scene *scene, const scene_body *body, duet_error *err);

// Reads as many finite numbers as the scene has dimensions.
void scene_read_by_dims(lua_State *L, const field *f, double to[3]);

// The scene's own fields of motion.
void scene_read_body(lua_State *L, const field *f, void *scene);
void scene_read_heights(lua_State *L, const field *f, void *scene);
void scene_read_mesh(lua_State *L, const field *f, void *scene);
void scene_read_gravity(lua_State *L, const field *f, void *scene);
void scene_read_origin_edge(lua_State *L, const field *f, void *scene);
void scene_read_origin(lua_State *L, const field *f, void *scene);
void scene_read_attraction(lua_State *L, const field *f, void *scene);
void scene_read_boundary(lua_State *L, const field *f, void *scene);

// Makes the bodies of all objects of what was given, after the last field.
bool scene_fill_bodies(duet_scene *scene, duet_error *err);

#endif
