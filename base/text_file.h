// SPDX-License-Identifier: MIT
// Whole files as texts.
#ifndef BASE_TEXT_FILE_H
#define BASE_TEXT_FILE_H

#include "base/text.h"

// Reads a whole file, "-" for stdin; the bytes end with a NUL that length does not count.
// false with NOT_FOUND or IO_FAILED, naming the path; the text is then empty.
bool text_read_file(text *t, const char *path, duet_error *err);

// The same of a text or a NumPy file. BAD_INPUT at once for what is neither, as a device
// that never ends is: by a byte that is 0, or by the length of a line.
enum { TEXT_LINE_MOST = 1 << 24 };
bool text_read_lines(text *t, const char *path, duet_error *err);

// Whether a file of ours begins with these 16 bytes, which name its kind and version and end their
// line. BAD_INPUT names the path, what it begins with and what is expected.
bool text_check_magic(const text *t, const char magic[16], const char *path, duet_error *err);

// Writes a whole file, by output.h: all of it is there or nothing changes.
bool text_write_file(const char *path, const char *bytes, size_t n, duet_error *err);

#endif
