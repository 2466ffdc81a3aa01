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
    int folder; // that holds both names; -1: written directly
    text path;  // path as it was asked for
    text name;
    text part; // the name until all is written
    int slot;  // place where output_remove_parts finds that; -1: nowhere
} output;

// IO_FAILED, naming the path. Call output_close whatever this returns.
bool output_open(output *o, const char *path, duet_error *err);

// The same for a name in an open folder, which becomes the output's, and where
// no link is followed. The file's mode is `mode` less the umask.
bool output_open_in(output *o, int folder, const char *name, mode_t mode, duet_error *err);

// Waits until what was written is on the disk, as far as the place has one: a crash after
// output_close then leaves all of it.
bool output_sync(output *o, duet_error *err);

// Puts the file in its place where `keep` holds and all of it was written; else
// removes what there is. Gives back whether the file is in its place.
bool output_close(output *o, bool keep, duet_error *err);

// Whether a file can be written at that path, before the work that it is for; what is there stays
// as it is. IO_FAILED else. Pipes and devices that may be written are not opened, and pass.
bool output_check(const char *path, duet_error *err);

// Whether both paths lead to one plain file, or would if it were made: what is written to the one
// takes the place of the other. "-" is stdin as the first, and as the second no file.
bool output_replaces(const char *read_or_written, const char *path);

// Makes the folders that a path lies in, those that are missing. false with errno, and the
// path of the one that cannot be made in `failed`, an empty text or NULL.
bool output_make_folders(const char *path, mode_t mode, text *failed);

// The whole path of the temporary name, for others who write into the file. IO_FAILED if
// there is none: it is written directly.
bool output_part_path(const output *o, text *path, duet_error *err);

// Has output_remove_parts remove the file of such a path, which another process has opened,
// until it is forgotten. -1: it does not.
int output_watch_part(const char *path);
void output_forget_part(int slot);

// Removes what is half-written, for a program that is about to end in the middle. It
// takes no lock, and makes only calls that a signal's handler may make.
void output_remove_parts(void);

#endif
