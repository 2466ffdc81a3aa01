// SPDX-License-Identifier: MIT
// Trials in T4, the JSON format in which auto-tuners hand on their results.
#ifndef PROFILES_T4_H
#define PROFILES_T4_H

#include "profiles/store.h"

#include <stdio.h>

// Writes all trials of the store as one document, valid by T4's schema of results and by its
// schema of metadata (version 1.0.0); docs/store.md describes it. `name` is what messages call
// the file. IO_FAILED if it cannot be written.
bool profile_export_t4(store *s, FILE *out, const char *name, duet_error *err);

#endif
