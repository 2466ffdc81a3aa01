// SPDX-License-Identifier: MIT
// A motion is created, at once or in two calls, alone or as a domain of others, and destroyed.
#ifndef RUNTIME_MOTION_CREATE_H
#define RUNTIME_MOTION_CREATE_H

#include "runtime/duet.h"

// The objects of a motion: poses, or with origin cells large_poses [n]; the other is NULL.
duet_motion *motion_create(const duet_motion_def *def, const duet_pose *poses,
                           const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                           duet_error *err);

// The same in two calls: what the objects and the def say, without a device, and then the rest.
// After a failure of the second the motion is still to be destroyed.
duet_motion *motion_know(const duet_motion_def *def, const duet_pose *poses,
                         const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                         duet_error *err);
bool motion_open(duet_motion *m, duet_error *err);

#endif
