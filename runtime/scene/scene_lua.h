// SPDX-License-Identifier: MIT
// A scene while its script runs. What is wrong is raised as a Lua error; the reading's err
// keeps the status where a check of the scene's own refused an object.
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

#endif
