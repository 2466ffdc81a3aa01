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

// Adds nothing if t is NULL.
void text_add(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
void text_add_bytes(text *t, const char *bytes, size_t n);

// Adds bytes as visible_show shows them.
void text_add_visible(text *t, const char *chars, size_t n, const char *kept);

// Adds JSON whose strings may hold what is no UTF-8, which becomes U+FFFD, and DEL and U+0080 to
// U+009F, which become \u007f and so on and so stay what they are.
void text_add_json(text *t, const char *json);

const char *text_chars(const text *t); // never NULL
bool text_ok(const text *t, duet_error *err);
void text_free(text *t);

// Whether more than ending stands in chars and ends with it, in capitals or not.
bool text_ends_with(const char *chars, const char *ending);

// FNV-1a, by which a file of ours shows that it is whole.
uint64_t text_checksum(const char *bytes, size_t n);

#endif
