// SPDX-License-Identifier: MIT
#ifndef RUNTIME_SCENE_MESH_H
#define RUNTIME_SCENE_MESH_H

#include "gen/field.h"
#include "runtime/duet.h"

// Reads a mesh from the table on top of the stack; a file that it names lies beside that path, or,
// if no path is given, where the program runs. Raises for what is none. The vertices and triangles
// are the caller's either way: mesh_file_free.
void mesh_read(lua_State *L, duet_mesh *mesh, const char *beside);

#endif
