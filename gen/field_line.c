// SPDX-License-Identifier: MIT
// A table does not know the line it was written at. The line is looked for in
// the script's text instead, and told only if there is exactly one.
#define _GNU_SOURCE // memmem
#include "gen/field_line.h"
#include "gen/script.h"

#include <ctype.h>
#include <lauxlib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

// "name =" or "['name'] =" at this place, and not "name ==" or "surname =".
static bool gives_value(const char *source, const char *at, size_t length)
{
    if (at > source && is_word(at[-1]))
        return false;
    const char *after = at + length;
    after += strspn(after, "\"']");
    after += strspn(after, " \t\r\n");
    return after[0] == '=' && after[1] != '=';
}

// How often the name gets a value in a line, up to its comment.
static int count_in_line(const char *source, const char *line, const char *end, const char *name)
{
    int n = 0;
    size_t length = strlen(name);
    const char *comment = memmem(line, (size_t)(end - line), "--", 2);
    end = comment ? comment : end;
    for (const char *at = line; (at = memmem(at, (size_t)(end - at), name, length)); at += length)
        n += gives_value(source, at, length);
    return n;
}

static bool is_name(const char *name)
{
    const char *at = name;
    while (is_word(*at))
        ++at;
    return at > name && *at == '\0';
}

// 0 if there is none or more than one. Each byte is looked at a few times
// only, however often a script repeats the name.
static int line_of(const char *source, const char *name)
{
    int only = 0;
    int n = 0;
    const char *line = source;
    for (int i = 1; n < 2 && *line && is_name(name); ++i) {
        const char *end = line + strcspn(line, "\n");
        int here = count_in_line(source, line, end, name);
        only = here > 0 ? i : only;
        n += here;
        line = end + (*end == '\n');
    }
    return n == 1 ? only : 0;
}

int field_line(lua_State *L, const char *name)
{
    const char *file = NULL;
    const char *source = script_chunk(L, &file);
    return source ? line_of(source, name) : 0;
}

int field_raise(lua_State *L, const char *name, const char *format, ...)
{
    const char *file = NULL;
    const char *source = script_chunk(L, &file);
    lua_Debug caller;
    char message[1000];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    if (lua_getstack(L, 1, &caller) || !source)
        return luaL_error(L, "%s", message);
    int line = name ? line_of(source, name) : 0;
    if (line > 0)
        lua_pushfstring(L, "%s:%d: %s", file, line, message);
    else
        lua_pushfstring(L, "%s: %s", file, message);
    return lua_error(L);
}
