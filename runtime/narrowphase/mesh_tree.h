// SPDX-License-Identifier: MIT
// A tree of the bounds of a mesh's triangles, seen from its origin.
#ifndef RUNTIME_MESH_TREE_H
#define RUNTIME_MESH_TREE_H

#include "runtime/duet.h"

#define MESH_NO_TRIANGLE UINT32_MAX

// A node is followed by those under it: two, or none under a triangle.
typedef struct mesh_node {
    float bounds[6]; // lower and upper corner
    uint32_t skip;   // the node behind all that lies under it
    uint32_t triangle;
} mesh_node;

static inline size_t mesh_tree_size(const duet_mesh *mesh)
{
    return 2 * (size_t)mesh->n_triangles - 1;
}

// Makes the nodes [mesh_tree_size] of a mesh that was checked, from the root on; NULL: no memory.
mesh_node *mesh_tree_make(const duet_mesh *mesh);

#endif
