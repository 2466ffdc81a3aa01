// SPDX-License-Identifier: MIT
// Scenes as Lua files. A scene that is read twice is the same twice.
#include "support/fuzz.h"
#include "support/objects.h"

void fuzz_one(const uint8_t *data, size_t n)
{
    static const duet_setting few = {"n", "10"};
    fuzz_path path = fuzz_file("input.lua", data, n);
    duet_error err = {0};
    duet_scene *scene = duet_scene_load(path.chars, NULL, 0, &err);
    fuzz_require_answer(scene != NULL, &err);
    err = (duet_error){0};
    duet_scene *again = duet_scene_load(path.chars, scene ? NULL : &few, scene ? 0 : 1, &err);
    fuzz_require_answer(again != NULL, &err);
    if (again)
        fuzz_require_objects(again);
    if (scene) {
        fuzz_require(again);
        fuzz_require_same(scene, again);
    }
    duet_scene_destroy(scene);
    duet_scene_destroy(again);
}
