// SPDX-License-Identifier: MIT
// Meshes as files: STL, binary and ASCII, and OBJ.
#ifndef RUNTIME_MESH_FILE_H
#define RUNTIME_MESH_FILE_H

#include "runtime/duet.h"

// Reads the vertices, times `scale`, and the triangles of a file, which its ending says the kind
// of. They are the caller's, also after a failure: mesh_file_free. BAD_INPUT names the file and the
// line or triangle, and what is expected.
bool mesh_file_read(duet_mesh *mesh, const char *path, double scale, duet_error *err);
void mesh_file_free(duet_mesh *mesh);

#endif
