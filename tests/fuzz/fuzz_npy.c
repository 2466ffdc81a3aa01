// SPDX-License-Identifier: MIT
// Objects as NumPy arrays, as they are and in origin cells.
#include "support/fuzz.h"
#include "support/objects.h"

static bool load(const char *path, const duet_setting *settings, uint32_t n_settings)
{
    duet_error err = {0};
    duet_scene *scene = duet_scene_load(path, settings, n_settings, &err);
    fuzz_require_answer(scene != NULL, &err);
    if (scene)
        fuzz_require_objects(scene);
    duet_scene_destroy(scene);
    return scene != NULL;
}

void fuzz_one(const uint8_t *data, size_t n)
{
    static const duet_setting cells[] = {{"origin", "cell"}, {"origin_edge", "4"}};
    fuzz_path path = fuzz_file("input.npy", data, n);
    if (load(path.chars, NULL, 0))
        load(path.chars, cells, 2);
}
