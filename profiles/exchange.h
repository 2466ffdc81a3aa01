// SPDX-License-Identifier: MIT
// Rows out and in as JSON lines, and the rows of another store.
//
// A row that comes in keeps its session, machine and date. Rows that are here
// already are counted and left alone; where both have a live profile for one
// key, the store's own stays live.
#ifndef PROFILES_EXCHANGE_H
#define PROFILES_EXCHANGE_H

#include "profiles/store.h"

#include <stdio.h>

typedef struct profile_import_counts {
    uint64_t added;
    uint64_t known; // were here already
} profile_import_counts;

// The whole store; docs/store.md describes the lines. `name` is what messages
// call the file. IO_FAILED if it cannot be written.
bool profile_export(store *s, FILE *out, const char *name, duet_error *err);

// The same, or profile_export_t4, to a file. BAD_ARGUMENT if that file is the store.
typedef bool profile_export_format(store *s, FILE *out, const char *name, duet_error *err);
bool profile_export_file(store *s, profile_export_format *format, const char *path,
                         duet_error *err);

// All rows or none. `name` is what messages call the file: BAD_INPUT with
// "name:line: what".
bool profile_import(store *s, FILE *in, const char *name, profile_import_counts *counts,
                    duet_error *err);

// Takes over the rows of another store, which is only read.
bool profile_merge(store *s, const char *other_path, profile_import_counts *counts,
                   duet_error *err);

#endif
