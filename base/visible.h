// SPDX-License-Identifier: MIT
// Makes untrusted bytes, from files, drivers and stores, fit to be shown: no control character
// reaches a terminal, and nothing that is not UTF-8 a file that promises it.
#ifndef BASE_VISIBLE_H
#define BASE_VISIBLE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

// Bytes of the character at `at`, 1 to 4; 0 if there is no UTF-8 character.
size_t utf8_length(const char *at);

bool utf8_is_valid(const char *chars);

// Whether a character of so many bytes is U+0000 to U+001F, U+007F, or U+0080 to U+009F.
bool utf8_is_control(const char *at, size_t length);

// How the first character of n bytes is shown: as it is, or, where it is a control character or
// not UTF-8, as \x1b for each byte. Characters of `kept`, "\n" say, stay. Returns how many
// bytes that was.
enum { VISIBLE_MOST = 4 * 4 + 1 };
size_t visible_show(const char *at, size_t n, const char *kept, char shown[VISIBLE_MOST]);

// Writes a line of `size` bytes with its end. A text that is too long, as with a long path, loses
// its middle: the end says what is wrong.
void visible_write(char *line, size_t size, const char *format, va_list args);

// Shows a line in place, of `size` bytes with its end: what does not fit is left out, and so is a
// character that was cut.
void visible_line(char *line, size_t size);

#endif
