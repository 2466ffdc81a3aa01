// SPDX-License-Identifier: MIT
// Fields of a motion's def in tables of Lua, for scenes and for scripts alike.
#ifndef RUNTIME_SCENE_FIELDS_H
#define RUNTIME_SCENE_FIELDS_H

#include "gen/field.h"
#include "runtime/duet_motion.h"

// Names of enums; NULL past the last.
const char *scene_boundary_name(int boundary);
const char *scene_integrator_name(int integrator);

// The bit of duet_effect_name; 0 where no effect is called that.
uint32_t scene_effect_named(const char *name);
void scene_push_effects(lua_State *L, uint32_t effects); // a list of their names

extern const field_type field_effects; // bits, as a list of effects' names

// Lists of a duet_motion_def:
//   materials       { { friction = , restitution = , friction_rule = , restitution_rule = }, ... }
//   material_pairs  { { a, b, friction = , restitution = }, ... }
extern const field_type field_materials;
extern const field_type field_material_pairs;

#endif
