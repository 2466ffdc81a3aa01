// SPDX-License-Identifier: MIT
// The ground of a motion as a file of VTK: its places, and a strip of triangles for each row of cells.
#ifndef CLI_VTK_GROUND_H
#define CLI_VTK_GROUND_H

#include "runtime/duet.h"

// Writes ground.vtp into a folder. heights NULL: there is no ground, and no file.
bool vtk_ground_write(const char *folder, const duet_heights *heights, double time,
                      duet_error *err);

#endif
