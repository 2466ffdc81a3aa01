// SPDX-License-Identifier: MIT
// The ground of a motion as a file of VTK: places of heights, and a strip of triangles for each row
// of cells, or a mesh's vertices and triangles.
#ifndef CLI_VTK_GROUND_H
#define CLI_VTK_GROUND_H

#include "runtime/duet.h"

// Writes the ground of a def that has one.
bool vtk_ground_write(const char *path, const duet_motion_def *def, double time, duet_error *err);

// Writes ground.vtp into a folder. A def without a ground has no file.
bool vtk_ground_write_once(const char *folder, const duet_motion_def *def, double time,
                           duet_error *err);

#endif
