// SPDX-License-Identifier: MIT
// What a motion can be made of.
#ifndef RUNTIME_MOTION_DEF_H
#define RUNTIME_MOTION_DEF_H

#include "runtime/duet.h"

// Say what is wrong with a pose, a body or a def; err tells a def's fault.
const char *motion_pose_fault(const duet_pose *pose, uint32_t dims);
const char *motion_body_fault(const duet_motion_def *def, const duet_body *body);
bool motion_check_def(const duet_motion_def *def, duet_error *err);

#endif
