// SPDX-License-Identifier: MIT
// A .vtu file of a motion's bodies: an unstructured grid with one cell for each, in the order of
// their places.
#ifndef CLI_VTK_BODIES_H
#define CLI_VTK_BODIES_H

#include "cli/body_states.h"
#include "cli/vtk/solid.h"

// solids: solids_make of dims.
bool vtk_bodies_write(const char *path, const body_states *bodies, const solid solids[SOLID_KINDS],
                      uint32_t dims, double time, duet_error *err);

// A .pvtu file of the same: of n files STEM_0.vtu and so on, beside it.
bool vtk_bodies_write_parallel(const char *path, const char *stem, uint32_t n, double time,
                               duet_error *err);

#endif
