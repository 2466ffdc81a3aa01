// SPDX-License-Identifier: MIT
#include "base/text.h"

#include "base/visible.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool reserve(text *t, size_t more)
{
    if (t->failed)
        return false;
    if (t->capacity - t->length > more)
        return true;
    size_t wanted = t->length + more + 1;
    size_t capacity = t->capacity ? t->capacity : 256;
    while (capacity < wanted)
        capacity *= 2;
    char *chars = realloc(t->chars, capacity);
    if (!chars) {
        t->failed = true;
        return false;
    }
    t->chars = chars;
    t->capacity = capacity;
    return true;
}

void text_add_bytes(text *t, const char *bytes, size_t n)
{
    if (!reserve(t, n))
        return;
    if (n > 0)
        memcpy(t->chars + t->length, bytes, n);
    t->length += n;
    t->chars[t->length] = '\0';
}

void text_add(text *t, const char *format, ...)
{
    va_list args;
    if (!t)
        return;
    va_start(args, format);
    int n = vsnprintf(NULL, 0, format, args);
    va_end(args);
    if (n < 0 || !reserve(t, (size_t)n))
        return;
    va_start(args, format);
    vsnprintf(t->chars + t->length, (size_t)n + 1, format, args);
    va_end(args);
    t->length += (size_t)n;
}

void text_add_visible(text *t, const char *chars, size_t n, const char *kept)
{
    char shown[VISIBLE_MOST];
    for (size_t i = 0; i < n;) {
        i += visible_show(chars + i, n - i, kept, shown);
        text_add_bytes(t, shown, strlen(shown));
    }
}

static void add_json_character(text *t, const char *at, size_t length)
{
    if (length == 0)
        text_add(t, "\xef\xbf\xbd");
    else if (utf8_is_control(at, length) && *at == 0x7f)
        text_add(t, "\\u007f");
    else if (utf8_is_control(at, length) && length == 2)
        text_add(t, "\\u00%02x", (unsigned)(unsigned char)at[1]);
    else
        text_add_bytes(t, at, length);
}

// Beyond ASCII, and for DEL, there are only strings.
void text_add_json(text *t, const char *json)
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

const char *text_chars(const text *t)
{
    return t->chars ? t->chars : "";
}

bool text_ok(const text *t, duet_error *err)
{
    return !t->failed || no_memory(err, "a text of %zu bytes", t->length);
}

void text_free(text *t)
{
    free(t->chars);
    *t = (text){0};
}

bool text_ends_with(const char *chars, const char *ending)
{
    size_t n = strlen(chars), m = strlen(ending);
    return n > m && strcasecmp(chars + n - m, ending) == 0;
}

uint64_t text_checksum(const char *bytes, size_t n)
{
    uint64_t sum = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < n; ++i)
        sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(0x100000001b3);
    return sum;
}
