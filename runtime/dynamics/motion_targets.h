// SPDX-License-Identifier: MIT
// Targets that commands leave to a step, which bodies reach in it, and commands that end with it.
#ifndef RUNTIME_MOTION_TARGETS_H
#define RUNTIME_MOTION_TARGETS_H

#include "runtime/dynamics/motion_commands.h"

// A pose with a target's centre and rotation; their z counts only in 3D.
duet_pose motion_aim(const duet_motion *m, duet_pose pose, const duet_transform *target);

// Forgets the targets of some places, whose bodies then stand still.
bool motion_forget_targets(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);

// Puts bodies exactly at their targets after a step.
bool motion_arrive(duet_motion *m, duet_error *err);

// Ends the other commands after a step: removed bodies are forgotten, and forces are over.
bool motion_end_commands(duet_motion *m, duet_error *err);

#endif
