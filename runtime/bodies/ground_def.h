// SPDX-License-Identifier: MIT
// The ground of a motion's def, of either shape.
#ifndef RUNTIME_GROUND_DEF_H
#define RUNTIME_GROUND_DEF_H

#include "runtime/duet.h"

static inline bool ground_def_is_given(const duet_motion_def *def)
{
    return def->heights || def->mesh;
}

// 0: it has none.
static inline uint32_t ground_def_material(const duet_motion_def *def)
{
    return def->mesh ? def->mesh->material : def->heights ? def->heights->material : 0;
}

// 1 + the id of the body that carries it; 0: it never moves.
static inline uint32_t ground_def_carrier(const duet_motion_def *def)
{
    return def->mesh ? def->mesh->carrier : 0;
}

// BAD_ARGUMENT for a ground that no motion can have, and for one that no such bodies can carry.
bool ground_def_check(const duet_motion_def *def, duet_error *err);
bool ground_def_check_carrier(const duet_motion_def *def, const duet_body *bodies, uint32_t n,
                              duet_error *err);

#endif
