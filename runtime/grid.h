// SPDX-License-Identifier: MIT
// The uniform grid's geometry: where it lies, how many cells, how wide.
//
// Objects meet in neighbouring cells only if no object is wider than a cell.
// Cell coordinates are computed in float, which can misplace a centre by
// u * cells (u = 2^-24) twice over; the edge is therefore wider than the
// widest object by the margin 2^-16 + cells * 2^-21, and an axis has at most
// 65 536 cells. Objects outside the grid count to its border cells.
#ifndef RUNTIME_GRID_H
#define RUNTIME_GRID_H

#include "runtime/duet.h"

#include <CL/cl.h>

typedef struct grid {
    uint32_t cells[3]; // 1 in z in 2D
    uint32_t n_cells;
    cl_float4 lower;
    cl_float4 per_cell; // 1 / edge
    cl_float4 limit;    // an extent above it does not fit: the edge less its margin
    float edge;         // the least over the axes
    uint32_t key_bits;  // of n_cells, the key of objects that are left out
} grid;

// What the objects need: bad ones are not counted.
typedef struct grid_needs {
    double lower[3]; // of the centres
    double upper[3];
    double widest;      // the largest extent of any bounds
    uint32_t widest_id; // whose it is
} grid_needs;

grid_needs grid_needs_of_poses(const duet_pose *poses, uint32_t n, uint32_t dims);
grid_needs grid_needs_of_bounds(const duet_bounds *bounds, uint32_t n, uint32_t dims);

// Cells of at least `edge` (and never below the widest object) over the box
// lower .. upper, but no more of them than memory for n objects allows.
grid grid_fit(const double lower[3], const double upper[3], double edge, uint32_t n, uint32_t dims);

#endif
