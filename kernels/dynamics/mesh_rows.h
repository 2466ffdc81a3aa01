//@ if GROUND == 2 then
// SPDX-License-Identifier: MIT
// A mesh as kernels read it: rows of words, of which the host makes all
// (runtime/bodies/mesh_rows.c).
#ifndef DUET_MESH_ROWS_H
#define DUET_MESH_ROWS_H

#define MESH_NONE 0xFFFFFFFFu

// A triangle: its vertices, of which those at one place have one number; the next corner at the place of each, in a
// ring, as 3 times its triangle and its place there; its normal in float.
#define MESH_NEXT 3
#define MESH_NORMAL 6
#define MESH_TRIANGLE 9

// A node of the tree: lower and upper corner in float; the node behind all that lies under it; its triangle, or NONE.
#define MESH_SKIP 6
#define MESH_LEAF 7
#define MESH_NODE 8

#endif
//@ end
