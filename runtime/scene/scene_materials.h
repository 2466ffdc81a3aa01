// SPDX-License-Identifier: MIT
// Materials of a def as tables of Lua, for scenes and for scripts alike.
#ifndef RUNTIME_SCENE_MATERIALS_H
#define RUNTIME_SCENE_MATERIALS_H

#include "runtime/duet_motion.h"

#include <lua.h>

// Read the value on top of the stack into def:
//   materials       { { friction = , restitution = , friction_rule = , restitution_rule = }, ... }
//   material_pairs  { { a, b, friction = , restitution = }, ... }
// NULL, or what is expected of row *row, counted from 1; row 0: of the value itself.
const char *scene_take_materials(lua_State *L, duet_motion_def *def, lua_Integer *row);
const char *scene_take_material_pairs(lua_State *L, duet_motion_def *def, lua_Integer *row);

#endif
