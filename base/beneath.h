// SPDX-License-Identifier: MIT
// Whether a path stays below the current folder.
#ifndef BASE_BENEATH_H
#define BASE_BENEATH_H

#include <stdbool.h>

// false for a path that begins at the root, has a part "..", or goes through or
// to a link, wherever that leads. What does not exist leads nowhere.
bool path_is_beneath(const char *path);

#endif
