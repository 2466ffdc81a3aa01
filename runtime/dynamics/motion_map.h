// SPDX-License-Identifier: MIT
// Parts of the state that the caller has mapped.
#ifndef RUNTIME_MOTION_MAP_H
#define RUNTIME_MOTION_MAP_H

#include "runtime/duet_motion_map.h"
#include "runtime/dynamics/motion.h"

// The buffer of a part of the state; false, by name, where there is no such part or the motion
// lacks what it needs.
bool motion_part_buffer(const duet_motion *m, duet_state_part part, motion_buffer *which,
                        const char *call, duet_error *err);

// BAD_ARGUMENT where something is mapped.
bool motion_is_unmapped(const duet_motion *m, const char *call, duet_error *err);

// Without writing what was mapped.
void motion_forget_maps(duet_motion *m);

#endif
