// SPDX-License-Identifier: MIT
// The ground of a motion as a file of VTK: its places, and a strip of triangles for each row of cells.
#ifndef CLI_VTK_GROUND_H
#define CLI_VTK_GROUND_H

#include "runtime/duet.h"

bool vtk_ground_write(const char *path, const duet_heights *heights, double time, duet_error *err);

#endif
