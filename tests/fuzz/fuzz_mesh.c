// SPDX-License-Identifier: MIT
// Meshes as STL and OBJ. A mesh that is taken is one that a motion can have, but for its tree.
#include "support/fuzz.h"

#include "runtime/narrowphase/mesh.h"
#include "runtime/scene/mesh_file.h"

void fuzz_one(const uint8_t *data, size_t n)
{
    static const char *const names[] = {"input.stl", "input.obj"};
    for (int i = 0; i < 2; ++i) {
        duet_error err = {0};
        duet_mesh mesh;
        bool ok = mesh_file_read(&mesh, fuzz_file(names[i], data, n).chars, 1, &err);
        fuzz_require_answer(ok, &err);
        fuzz_require(!ok || mesh_check(&mesh, &err));
        mesh_file_free(&mesh);
    }
}
