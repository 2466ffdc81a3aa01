// SPDX-License-Identifier: MIT
// Whether anybody writes a store's file. One that rests can be read without
// locks and without SQLite's side files. Internal to this module.
#ifndef PROFILES_UNLOCKED_READ_H
#define PROFILES_UNLOCKED_READ_H

#include "base/error.h"
#include "base/text.h"

#include <sys/stat.h>

typedef struct unlocked_read {
    bool holds;
    struct stat seen; // the file then
} unlocked_read;

// Whether it has rested since, so that what was read counts.
bool unlocked_read_holds(const char *path, const unlocked_read *before);

// The same, but waits up to 60 ms for a file that was written a moment ago to
// count as one that rests.
unlocked_read unlocked_read_begin(const char *path);

// Whether the file itself is as it was; false with a line if not. The side file
// of a writer is no part of it.
bool unlocked_read_check(const char *path, const unlocked_read *before, duet_error *err);

// Whether a writer is at work, or was killed: a side file holds something.
bool unlocked_read_has_side_file(const char *path);

// The name by which SQLite reads the file as one that does not change.
void unlocked_read_uri(const char *path, text *uri);

#endif
