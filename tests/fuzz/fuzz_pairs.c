// SPDX-License-Identifier: MIT
// Pairs of poses for `duet query`: a NumPy array where the input begins as one,
// else text.
#include "support/fuzz.h"
#include "support/objects.h"

void fuzz_one(const uint8_t *data, size_t n)
{
    bool npy = n > 0 && data[0] == 0x93;
    fuzz_path path = fuzz_file(npy ? "input.npy" : "input.csv", data, n);
    duet_error err = {0};
    duet_scene *pairs = duet_scene_load_pairs(path.chars, &err);
    fuzz_require_answer(pairs != NULL, &err);
    if (pairs) {
        fuzz_require_objects(pairs);
        fuzz_require(duet_scene_get_info(pairs)->n % 2 == 0);
    }
    duet_scene_destroy(pairs);
}
