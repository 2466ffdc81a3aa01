// SPDX-License-Identifier: MIT
// Text of strangers, from files, drivers and stores, made fit to be shown or
// put into a document: no control character reaches a terminal, and nothing
// that is not UTF-8 a file that promises it.
#ifndef BASE_VISIBLE_H
#define BASE_VISIBLE_H

#include "base/text.h"

// Bytes of the character at `at`, 1 to 4; 0 where there is no UTF-8 character.
size_t utf8_length(const char *at);

bool utf8_is_valid(const char *chars);

// Adds the bytes with control characters, and what is not UTF-8, as \x1b. Those
// of `kept`, "\n" say, stay as they are.
void visible_add(text *t, const char *chars, size_t n, const char *kept);

// The same of a line in place, of `size` bytes with its end: what does not fit is left out, and so
// is a character that was cut.
void visible_line(char *line, size_t size);

// Adds JSON whose strings may hold what is no UTF-8, which becomes U+FFFD, and
// DEL and U+0080 to U+009F, which become \u007f and so on and so stay what they
// are.
void visible_add_json(text *t, const char *json);

#endif
