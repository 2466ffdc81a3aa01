// SPDX-License-Identifier: MIT
#include "base/visible.h"

#include <stdio.h>
#include <stdlib.h>
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

// U+0000 to U+001F, U+007F, and U+0080 to U+009F.
bool utf8_is_control(const char *at, size_t length)
{
    unsigned char c = (unsigned char)*at;
    return length == 1 ? c < 0x20 || c == 0x7f
                       : length == 2 && c == 0xc2 && (unsigned char)at[1] < 0xa0;
}

static size_t length_within(const char *at, size_t n)
{
    char end[5] = {0}; // whatever follows the last byte belongs to nobody
    memcpy(end, at, n < 4 ? n : 4);
    return utf8_length(end);
}

size_t visible_show(const char *at, size_t n, const char *kept, char shown[VISIBLE_MOST])
{
    size_t length = length_within(at, n), taken = length > 0 ? length : 1;
    bool stays = length == 1 && *at != '\0' && strchr(kept, *at);
    if (stays || (length > 0 && !utf8_is_control(at, length))) {
        memcpy(shown, at, length);
        shown[length] = '\0';
        return length;
    }
    for (size_t k = 0; k < taken; ++k)
        snprintf(shown + 4 * k, 5, "\\x%02x", (unsigned)(unsigned char)at[k]);
    return taken;
}

// A byte of a character that began before it.
static bool is_inside(char byte)
{
    return ((unsigned char)byte & 0xc0) == 0x80;
}

void visible_write(char *line, size_t size, const char *format, va_list args)
{
    va_list again;
    va_copy(again, args);
    int length = vsnprintf(line, size, format, args);
    char *whole = length >= (int)size ? malloc((size_t)length + 1) : NULL;
    if (whole) {
        size_t head = size - size / 4, tail = (size_t)length - size / 4 + sizeof "...";
        vsnprintf(whole, (size_t)length + 1, format, again);
        for (int k = 0; k < 3 && is_inside(whole[head]); ++k) // what is no text may go on like that
            --head;
        while (is_inside(whole[tail]))
            ++tail;
        snprintf(line + head, size - head, "...%s", whole + tail);
    }
    free(whole);
    va_end(again);
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
    drop_cut_character(line);
    for (size_t at = 0, length = strlen(line); at < length;) {
        char shown[VISIBLE_MOST];
        size_t taken = visible_show(line + at, length - at, "", shown);
        size_t n = strlen(shown), space = size - 1 - at, rest = length - at - taken;
        bool all = n + rest <= space;
        if (n == taken) { // shown as it is
            at += n;
            continue;
        }
        if (n > space) {
            line[at] = '\0';
            return;
        }
        rest = all ? rest : space - n;
        memmove(line + at + n, line + at + taken, rest);
        memcpy(line + at, shown, n);
        line[at + n + rest] = '\0';
        if (!all)
            drop_cut_character(line);
        at += n;
        length = at + strlen(line + at);
    }
}
