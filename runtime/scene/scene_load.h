// SPDX-License-Identifier: MIT
// Scenes of which only a part is kept; duet_scene_load keeps all.
#ifndef RUNTIME_SCENE_LOAD_H
#define RUNTIME_SCENE_LOAD_H

#include "runtime/duet.h"

// duet_scene_load that keeps the objects [first, end) of all that the scene has, whose number
// it writes to *n. Objects that `each` makes are made only where they are kept, and rows of a
// .npy file are read only there; others are read and passed over.
duet_scene *scene_load_range(const char *path, const duet_setting *settings, uint32_t n_settings,
                             uint64_t first, uint64_t end, uint64_t *n, duet_error *err);

// duet_scene_load in which `each` makes only its first object, and of a .npy file no other is read:
// *deferred are left out of all *n. If there are any, read parts of the scene by their ranges.
duet_scene *scene_load_deferred(const char *path, const duet_setting *settings, uint32_t n_settings,
                                uint64_t *n, uint64_t *deferred, duet_error *err);

#endif
