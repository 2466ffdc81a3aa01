// SPDX-License-Identifier: MIT
// Output files. A file is written under another name beside its place and
// renamed there, so that nobody ever sees half of it. A link stays and the file
// that it leads to is replaced. A device, a pipe or an open file of this
// process (/dev/stdout) is written directly. "-" is stdout.
//
//     output o;
//     bool ok = output_open(&o, path, err);
//     ok = ok && fputs("...", o.stream) >= 0;
//     return output_close(&o, ok, err);
#ifndef BASE_OUTPUT_H
#define BASE_OUTPUT_H

#include "base/error.h"
#include "base/text.h"

#include <stdio.h>
#include <sys/types.h>

typedef struct output {
    FILE *stream;
    int folder; // folder of both names; -1: written directly
    text path;  // the path of the caller
    text name;
    text part; // temporary name
    int slot;  // entry of output_remove_parts; -1: none
} output;

// IO_FAILED, naming the path. Call output_close whatever this returns.
bool output_open(output *o, const char *path, duet_error *err);

// Opens an output by its name in an open folder, which becomes the output's; follows no link. The
// file's mode is `mode` less the umask.
bool output_open_in(output *o, int folder, const char *name, mode_t mode, duet_error *err);

// Renames the file to its path if `keep` is true and all was written; otherwise removes it. Returns
// whether the file is in its place.
bool output_close(output *o, bool keep, duet_error *err);

// Checks, before long work, whether a file can be written at that path, and leaves an existing one
// as it is. IO_FAILED if not. Pipes and devices that may be written are not opened, and pass.
bool output_check(const char *path, duet_error *err);

// Says whether both paths lead to one plain file, or would if it were made, so that writing one
// replaces the other. "-" is stdin as the first, and as the second no file.
bool output_replaces(const char *read_or_written, const char *path);

// Makes the missing folders above a path. Returns false with errno, and the path of the folder that
// cannot be made in `failed`, an empty text or NULL.
bool output_make_folders(const char *path, mode_t mode, text *failed);

// Gets the whole path of the temporary name, for others who write into the file. IO_FAILED if it is
// written directly.
bool output_part_path(const output *o, text *path, duet_error *err);

// Lets output_remove_parts remove the file of such a path, which another process has opened, until
// it is forgotten. -1: no entry is free.
int output_watch_part(const char *path);
void output_forget_part(int slot);

// Removes half-written files, for a program that ends early. It takes no lock, and makes only calls
// that a signal's handler may make.
void output_remove_parts(void);

#endif
