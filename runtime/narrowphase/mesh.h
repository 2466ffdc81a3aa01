// SPDX-License-Identifier: MIT
// A ground of triangles, as it is given.
#ifndef RUNTIME_MESH_H
#define RUNTIME_MESH_H

#include "runtime/duet.h"

static inline const float *mesh_vertex(const duet_mesh *mesh, uint32_t i)
{
    return mesh->vertices + 3 * (size_t)i;
}

// Says what a vertex or a triangle is that no mesh can have, and what is expected; NULL: nothing.
const char *mesh_vertex_fault(const float at[3]);
const char *mesh_triangle_fault(const float a[3], const float b[3], const float c[3]);

// BAD_ARGUMENT for a mesh that nothing can have.
bool mesh_check(const duet_mesh *mesh, duet_error *err);

// Also for one whose places, origin + vertex in double, do not tell its triangles apart well.
bool mesh_check_places(const duet_mesh *mesh, duet_error *err);

// Sets the outward normal of a triangle, of length 1.
void mesh_set_normal(const float a[3], const float b[3], const float c[3], double normal[3]);

// Copies a mesh, with vertices and triangles of its own, which are the caller's to free.
bool mesh_copy(duet_mesh *to, const duet_mesh *mesh, duet_error *err);

// A carried mesh where its carrier is: vertices of its own, which are the caller's to free, and the
// same triangles.
bool mesh_carry(duet_mesh *to, const duet_mesh *mesh, const duet_state *carrier, duet_error *err);

// Sets the place of a vertex, or of a triangle's corner.
void mesh_place_vertex(const duet_mesh *mesh, uint32_t vertex, double at[3]);
void mesh_place(const duet_mesh *mesh, uint32_t triangle, uint32_t corner, double at[3]);

// Bytes of the vertices and of the triangles.
size_t mesh_vertex_bytes(const duet_mesh *mesh);
size_t mesh_triangle_bytes(const duet_mesh *mesh);

#endif
