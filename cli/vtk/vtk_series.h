// SPDX-License-Identifier: MIT
// Files that follow each other in time, NAME_00000.ENDING and so on, and NAME.pvd, which says when
// each of them is. That is written anew, aside and renamed, after each file, so that it names whole
// files alone however the program ends.
#ifndef CLI_VTK_SERIES_H
#define CLI_VTK_SERIES_H

#include "base/text.h"

typedef struct vtk_series {
    const char *folder;
    const char *name;
    const char *ending;
    uint64_t n; // files so far
    text path;
    text entries;
} vtk_series;

// Returns the next file's path, the series'.
const char *vtk_series_next(vtk_series *s, duet_error *err);
// Adds that file, once it is there.
bool vtk_series_add(vtk_series *s, double time, duet_error *err);
void vtk_series_free(vtk_series *s);

#endif
