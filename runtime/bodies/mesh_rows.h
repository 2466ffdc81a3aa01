// SPDX-License-Identifier: MIT
// A mesh as kernels read it (kernels/dynamics/mesh_rows.h).
#ifndef RUNTIME_MESH_ROWS_H
#define RUNTIME_MESH_ROWS_H

#include "runtime/narrowphase/mesh_tree.h"

typedef struct mesh_rows {
    uint32_t *triangles; // [n_triangles][MESH_TRIANGLE]
    mesh_node *nodes;    // [mesh_tree_size]
    uint32_t n_triangles;
} mesh_rows;

// Makes the rows of a mesh that was checked. NO_MEMORY leaves none; free them whatever this
// returns.
bool mesh_rows_make(mesh_rows *rows, const duet_mesh *mesh, duet_error *err);
void mesh_rows_free(mesh_rows *rows);

#endif
