// SPDX-License-Identifier: MIT
// A motion's bodies as boxes for a tree. Hidden bodies (runtime/dynamics/motion_commands.h)
// have negative half extents.
#ifndef RUNTIME_MOTION_POSES_H
#define RUNTIME_MOTION_POSES_H

#include "runtime/duet.h"
#include "runtime/opencl/buffer.h"

// Whether some body has a radius, or had one; poses are the cores then.
bool motion_has_radii(const duet_motion *m);

// Whether B's memory holds everything that the boxes need, with radii or without.
bool motion_has_poses(const duet_motion *m, bool radii);

// Writes them on B into rows [n] of B's memory: poses, or with radii rounded boxes.
bool motion_write_poses(duet_motion *m, bool radii, const buffer *rows, duet_error *err);

// The same through the host, for any motion.
bool motion_copy_poses(duet_motion *m, bool radii, void *rows, duet_error *err);

// The same for a motion in origin cells: each pose with its cell.
bool motion_copy_large_poses(duet_motion *m, duet_large_pose *poses, duet_error *err);

#endif
