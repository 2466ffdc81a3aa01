// SPDX-License-Identifier: MIT
// The scenes that come with Duet, carried inside the library.
#ifndef RUNTIME_SCENE_SHIPPED_H
#define RUNTIME_SCENE_SHIPPED_H

#include "base/blob.h"

#include <stdbool.h>

typedef struct shipped_scene {
    char name[24];   // "paper"
    char about[100]; // the first line of its comment
    const blob *file;
} shipped_scene;

// The i-th by name; false after the last.
bool shipped_at(unsigned i, shipped_scene *scene);

// A name is a word without '/' and '.'; a file that is called so is read as "./paper".
bool shipped_find(const char *name, shipped_scene *scene);

// Finds the name that a mistyped one was probably meant to be; false if none is near.
bool shipped_find_nearest(const char *typed, shipped_scene *scene);

#endif
