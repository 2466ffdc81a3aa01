// SPDX-License-Identifier: MIT
// A motion's step in two halves.
#ifndef RUNTIME_MOTION_HALVES_H
#define RUNTIME_MOTION_HALVES_H

#include "runtime/dynamics/motion.h"

// Whether a step has begun that was not ended; whether a public call has a motion where none
// has, BAD_ARGUMENT where it has not.
bool motion_is_under_way(const duet_motion *m);
bool motion_is_idle(const duet_motion *m, const char *call, duet_error *err);

// Waits for a step that has begun, and forgets it.
void motion_end_half(duet_motion *m);

#endif
