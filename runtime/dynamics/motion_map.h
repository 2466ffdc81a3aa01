// SPDX-License-Identifier: MIT
// Parts of the state that the caller has mapped.
#ifndef RUNTIME_MOTION_MAP_H
#define RUNTIME_MOTION_MAP_H

#include "runtime/duet_motion_map.h"
#include "runtime/dynamics/motion.h"

// BAD_ARGUMENT where something is mapped.
bool motion_is_unmapped(const duet_motion *m, const char *call, duet_error *err);

// Without writing what was mapped.
void motion_forget_maps(duet_motion *m);

#endif
