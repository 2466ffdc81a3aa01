// SPDX-License-Identifier: MIT
#ifndef RUNTIME_SCENE_MESH_H
#define RUNTIME_SCENE_MESH_H

#include "runtime/duet.h"

#include <lua.h>

// Reads a mesh from the table on top of the stack; a file that it names lies beside that path, or,
// if no path is given, where the program runs. False with BAD_INPUT or BAD_ARGUMENT that says what
// is wrong. The vertices and triangles are the caller's either way: mesh_file_free.
bool mesh_read(lua_State *L, duet_mesh *mesh, const char *beside, duet_error *err);

#endif
