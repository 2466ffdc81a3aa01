// SPDX-License-Identifier: MIT
// The materials of a def: what a body's friction and restitution are, and by which rules those of
// two bodies become a contact's.
#ifndef RUNTIME_MATERIAL_H
#define RUNTIME_MATERIAL_H

#include "runtime/duet_motion.h"

// A material without friction or restitution, by the rules that bodies without a material have.
duet_material material_of_rules(void);

const char *material_rule_name(int rule); // "average" for 0; NULL past the last

bool materials_check(const duet_motion_def *def, duet_error *err);
bool materials_are_same(const duet_motion_def *a, const duet_motion_def *b);

// The numbers that count for a body: its own, or its material's.
float material_friction(const duet_motion_def *def, const duet_body *b);
float material_restitution(const duet_motion_def *def, const duet_body *b);

// Whether some contact of the body may have friction or restitution.
bool material_is_rough(const duet_motion_def *def, const duet_body *b);
bool material_is_elastic(const duet_motion_def *def, const duet_body *b);

// Fills the rows of kernels/dynamics/materials.h, of each two materials.
void material_fill_rules(const duet_motion_def *def, float *rules);

#endif
