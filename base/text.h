// SPDX-License-Identifier: MIT
// A string that grows. Zeroed is empty; text_free gives it back. When memory
// runs out the text is marked failed and stays as it was: check text_ok once.
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

#include "base/error.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct text {
    char *chars; // NUL-terminated once something was added; NULL before
    size_t length;
    size_t capacity;
    bool failed;
} text;

// Adds nothing where t is NULL.
void text_add(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
void text_add_bytes(text *t, const char *bytes, size_t n);
const char *text_chars(const text *t); // never NULL
bool text_ok(const text *t, duet_error *err);
void text_free(text *t);

// FNV-1a, by which a file of ours shows that it is whole.
uint64_t text_checksum(const char *bytes, size_t n);

// Reads a whole file, "-" for stdin; the bytes end with a NUL that length does not count.
// false with NOT_FOUND or IO_FAILED, naming the path; the text is then empty.
bool text_read_file(text *t, const char *path, duet_error *err);

// The same of a text or a NumPy file. BAD_INPUT at once for what is neither, as a device
// that never ends is: by a byte that is 0, or by the length of a line.
enum { TEXT_LINE_MOST = 1 << 24 };
bool text_read_lines(text *t, const char *path, duet_error *err);

// Writes a whole file, by output.h: all of it is there or nothing changes.
bool text_write_file(const char *path, const char *bytes, size_t n, duet_error *err);

#endif
