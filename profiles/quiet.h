// SPDX-License-Identifier: MIT
// Whether anybody writes a store's file. One that rests can be read without
// locks and without SQLite's side files. Internal to this room.
#ifndef PROFILES_QUIET_H
#define PROFILES_QUIET_H

#include "runtime/base/text.h"

#include <sys/stat.h>

typedef struct quiet {
    bool holds;
    struct stat seen; // the file then
} quiet;

quiet quiet_look(const char *path);

// Whether it has rested since, so that what was read counts.
bool quiet_still(const char *path, const quiet *before);

// The same, but waits up to 60 ms for a file that was written a moment ago to
// count as one that rests.
quiet quiet_wait(const char *path);

// Whether the file itself is as it was. What a writer has only in its side file
// is no part of it.
bool quiet_unchanged(const char *path, const quiet *before);

// Whether a writer is at work, or was killed: a side file holds something.
bool quiet_has_side_file(const char *path);

// The name by which SQLite reads the file as one that does not change.
void quiet_name(const char *path, text *uri);

#endif
