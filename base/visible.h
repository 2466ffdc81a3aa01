// SPDX-License-Identifier: MIT
// Untrusted text from files, drivers and stores, made safe to show: no control character reaches a
// terminal, and a file that promises UTF-8 holds nothing else.
#ifndef BASE_VISIBLE_H
#define BASE_VISIBLE_H

#include <stdbool.h>
#include <stddef.h>

// Returns the bytes of the character at `at`, 1 to 4; 0 if it is no UTF-8 character.
size_t utf8_length(const char *at);

bool utf8_is_valid(const char *chars);

// Says whether a character is U+0000 to U+001F, U+007F, or U+0080 to U+009F.
bool utf8_is_control(const char *at, size_t length);

// Shows the first character of n bytes: as it is, or as \x1b for each byte if it is a control
// character or not UTF-8. Characters in `kept`, such as "\n", stay as they are. Returns the
// character's bytes.
enum { VISIBLE_MOST = 4 * 4 + 1 };
size_t visible_show(const char *at, size_t n, const char *kept, char shown[VISIBLE_MOST]);

// Shows a line in place, in `size` bytes with its end: text that does not fit is left out, and so
// is a character that was cut.
void visible_line(char *line, size_t size);

#endif
