// SPDX-License-Identifier: MIT
// Frames of a motion for ParaView: bodies.pvd, contacts.pvd if bodies can touch, and ground.vtp if
// there is a ground, or ground.pvd if a body carries it.
#ifndef CLI_VTK_FRAMES_H
#define CLI_VTK_FRAMES_H

#include "cli/vtk/solid.h"
#include "cli/vtk/vtk_series.h"

typedef struct vtk_frames {
    duet_motion *motion; // the caller's
    vtk_series bodies;
    vtk_series contacts;
    vtk_series ground; // that is carried
    solid solids[SOLID_KINDS];
} vtk_frames;

void vtk_frames_begin(vtk_frames *f, const char *folder, duet_motion *motion);
bool vtk_frames_add(vtk_frames *f, double time, duet_error *err);
void vtk_frames_end(vtk_frames *f);

#endif
