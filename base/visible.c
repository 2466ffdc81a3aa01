// SPDX-License-Identifier: MIT
#include "base/visible.h"

#include <stdio.h>
#include <string.h>

// By the first byte: how many follow, and the least and greatest second byte,
// which leave out overlong forms, surrogates and what is above U+10FFFF.
typedef struct form {
    unsigned char first, last;
    unsigned char least, most;
    size_t length;
} form;

static const form forms[] = {
    {0xc2, 0xdf, 0x80, 0xbf, 2}, {0xe0, 0xe0, 0xa0, 0xbf, 3}, {0xe1, 0xec, 0x80, 0xbf, 3},
    {0xed, 0xed, 0x80, 0x9f, 3}, {0xee, 0xef, 0x80, 0xbf, 3}, {0xf0, 0xf0, 0x90, 0xbf, 4},
    {0xf1, 0xf3, 0x80, 0xbf, 4}, {0xf4, 0xf4, 0x80, 0x8f, 4},
};

static bool goes_on(const unsigned char *at, const form *f)
{
    if (at[1] < f->least || at[1] > f->most)
        return false;
    for (size_t i = 2; i < f->length; ++i)
        if ((at[i] & 0xc0) != 0x80)
            return false;
    return true;
}

// A NUL is a character too, and ends every other one that is cut.
size_t utf8_length(const char *at)
{
    const unsigned char *u = (const unsigned char *)at;
    if (*u < 0x80)
        return 1;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i)
        if (*u >= forms[i].first && *u <= forms[i].last)
            return goes_on(u, &forms[i]) ? forms[i].length : 0;
    return 0;
}

bool utf8_is_valid(const char *chars)
{
    size_t length = 1;
    for (; *chars && length > 0; chars += length)
        length = utf8_length(chars);
    return length > 0;
}

// U+0000 to U+001F, U+007F and U+0080 to U+009F.
static bool is_control(const char *at, size_t length)
{
    unsigned char c = (unsigned char)*at;
    return length == 1 ? c < 0x20 || c == 0x7f
                       : length == 2 && c == 0xc2 && (unsigned char)at[1] < 0xa0;
}

static size_t length_within(const char *at, size_t n)
{
    char end[5] = {0}; // what follows the last byte belongs to nobody
    memcpy(end, at, n < 4 ? n : 4);
    return utf8_length(end);
}

void visible_add(text *t, const char *chars, size_t n, const char *kept)
{
    for (size_t i = 0; i < n;) {
        size_t length = length_within(chars + i, n - i);
        bool stays = length == 1 && chars[i] != '\0' && strchr(kept, chars[i]);
        bool shown = stays || (length > 0 && !is_control(chars + i, length));
        if (shown)
            text_add_bytes(t, chars + i, length);
        for (size_t k = 0; !shown && k < (length > 0 ? length : 1); ++k)
            text_add(t, "\\x%02x", (unsigned)(unsigned char)chars[i + k]);
        i += length > 0 ? length : 1;
    }
}

static void drop_cut_character(char *line)
{
    size_t length = strlen(line);
    size_t begin = length;
    while (begin > 0 && length - begin < 3 && ((unsigned char)line[begin - 1] & 0xc0) == 0x80)
        --begin;
    if (begin > 0 && (unsigned char)line[begin - 1] >= 0xc0 && utf8_length(line + begin - 1) == 0)
        line[begin - 1] = '\0';
}

void visible_line(char *line, size_t size)
{
    text shown = {0};
    drop_cut_character(line);
    visible_add(&shown, line, strlen(line), "");
    if (!shown.failed && shown.chars && strcmp(shown.chars, line) != 0)
        snprintf(line, size, "%s", shown.chars);
    text_free(&shown);
}

static void add_json_character(text *t, const char *at, size_t length)
{
    if (length == 0)
        text_add(t, "\xef\xbf\xbd");
    else if (is_control(at, length) && *at == 0x7f)
        text_add(t, "\\u007f");
    else if (is_control(at, length) && length == 2)
        text_add(t, "\\u00%02x", (unsigned)(unsigned char)at[1]);
    else
        text_add_bytes(t, at, length);
}

// Beyond ASCII, and for DEL, there are only strings.
void visible_add_json(text *t, const char *json)
{
    for (const char *at = json; *at;) {
        const char *from = at;
        while (*at && (unsigned char)*at < 0x7f)
            ++at;
        text_add_bytes(t, from, (size_t)(at - from));
        if (!*at)
            return;
        size_t length = utf8_length(at);
        add_json_character(t, at, length);
        at += length > 0 ? length : 1;
    }
}
