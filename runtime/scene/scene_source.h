// SPDX-License-Identifier: MIT
// A scene's source, and the readers.
#ifndef RUNTIME_SCENE_SOURCE_H
#define RUNTIME_SCENE_SOURCE_H

#include "runtime/scene/scene.h"

// The source of a scene: a file, stdin, or a file that the library carries.
typedef struct scene_source {
    const char *name;  // the path, for messages
    const char *bytes; // followed by a NUL; NULL: they are in the file
    size_t length;
    int file; // open, where bytes is NULL
} scene_source;

// Whether its first line that is no comment and no header begins with a number.
bool scene_is_text(const scene_source *source);

// Each reader adds its objects to an empty scene.
bool scene_read_text(duet_scene *scene, const scene_source *source, duet_error *err);
bool scene_read_npy(duet_scene *scene, const scene_source *source, duet_error *err);
bool scene_read_lua(duet_scene *scene, const scene_source *source, const duet_setting *settings,
                    uint32_t n_settings, duet_error *err);

#endif
