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

// A part of the script's text, and the line that it begins in.
typedef struct span {
    const char *begin, *end;
    int line; // 0: there is none
} span;

static span whole_of(const char *source)
{
    return (span){source, source + strlen(source), 1};
}

// ---------------------------------------------------------------- values

// Finds what follows "name =" or "['name'] =" at this place, and not "name ==" or "surname ="; else
// NULL.
static const char *value_at(const char *source, const char *at, size_t length)
{
    if (at > source && is_word(at[-1]))
        return NULL;
    const char *after = at + length;
    after += strspn(after, "\"']");
    after += strspn(after, " \t\r\n");
    return after[0] == '=' && after[1] != '=' ? after + 1 : NULL;
}

// Adds how often the name gets a value in a line, up to its comment; the last one goes to *value.
static int count_in_line(span line, const char *begin, const char *name, span *value)
{
    int n = 0;
    size_t length = strlen(name);
    const char *comment = memmem(line.begin, (size_t)(line.end - line.begin), "--", 2);
    const char *end = comment ? comment : line.end;
    for (const char *at = line.begin; (at = memmem(at, (size_t)(end - at), name, length));
         at += length) {
        const char *after = value_at(begin, at, length);
        n += after != NULL;
        *value = after ? (span){after, value->end, line.line} : *value;
    }
    return n;
}

static bool is_name(const char *name)
{
    const char *at = name;
    while (is_word(*at))
        ++at;
    return at > name && *at == '\0';
}

// The text behind the name's "=", if exactly one gives it a value. Each byte is looked at a few
// times only, however often a script repeats the name.
static span find_value(span in, const char *name)
{
    span only = {.end = in.end};
    int n = 0;
    span line = in;
    for (; n < 2 && line.begin < in.end && is_name(name); ++line.line) {
        const char *newline = memchr(line.begin, '\n', (size_t)(in.end - line.begin));
        line.end = newline ? newline : in.end;
        n += count_in_line(line, in.begin, name, &only);
        line.begin = line.end + (newline != NULL);
    }
    return n == 1 ? only : (span){0};
}

// ---------------------------------------------------------------- rows

// "[==[" and what follows up to "]==]"; else at itself.
static const char *skip_long(const char *at, const char *end)
{
    size_t level = strspn(at + 1, "=");
    if (*at != '[' || at[1 + level] != '[')
        return at;
    for (at += level + 2; at < end; ++at)
        if (at[0] == ']' && strspn(at + 1, "=") == level && at[1 + level] == ']')
            return at + level + 2;
    return end;
}

// A comment, a string or one character of other text.
static const char *skip_token(const char *at, const char *end)
{
    bool is_comment = at[0] == '-' && at[1] == '-';
    const char *after = skip_long(at + 2 * is_comment, end);
    if (after > at + 2 * is_comment)
        return after;
    if (is_comment)
        return at + strcspn(at, "\n");
    char quote = *at++;
    if (quote != '"' && quote != '\'')
        return at;
    while (at < end && *at != quote && *at != '\n')
        at += at[0] == '\\' && at + 1 < end ? 2 : 1;
    return at + (at < end);
}

static int count_lines(const char *from, const char *to)
{
    int n = 0;
    for (; (from = memchr(from, '\n', (size_t)(to - from))); ++from)
        ++n;
    return n;
}

// Returns the text from `at` on.
static span rest_from(span in, const char *at)
{
    return (span){at, in.end, in.line + count_lines(in.begin, at)};
}

static span skip_blanks(span in)
{
    const char *at = in.begin;
    while (at < in.end && (isspace((unsigned char)*at) || strncmp(at, "--", 2) == 0))
        at = isspace((unsigned char)*at) ? at + 1 : skip_token(at, in.end);
    return rest_from(in, at);
}

// The table that the text begins with, with its braces; none if it begins otherwise.
static span find_table(span in)
{
    span table = skip_blanks(in);
    const char *at = table.begin;
    int depth = 0;
    if (at == in.end || *at != '{')
        return (span){0};
    do {
        depth += (*at == '{') - (*at == '}');
        at = skip_token(at, in.end);
    } while (depth > 0 && at < in.end);
    table.end = at;
    return table;
}

// The row of the list that the text begins with; none unless it and those before it are tables.
static span find_row(span list, lua_Integer row)
{
    span rest = skip_blanks(list), table = {0};
    for (lua_Integer i = 1; i <= row; ++i) {
        bool begins = rest.begin < rest.end &&
                      (i == 1 ? *rest.begin == '{' : *rest.begin == ',' || *rest.begin == ';');
        table = begins ? find_table(rest_from(rest, rest.begin + 1)) : (span){0};
        if (table.line == 0)
            return table;
        rest = skip_blanks(rest_from(rest, table.end));
    }
    return table;
}

// ---------------------------------------------------------------- lines

int field_line(lua_State *L, const char *name)
{
    const char *file = NULL;
    const char *source = script_chunk(L, &file);
    return source ? find_value(whole_of(source), name).line : 0;
}

int field_line_in_row(lua_State *L, const char *list, lua_Integer row, const char *name)
{
    const char *file = NULL;
    const char *source = script_chunk(L, &file);
    span rows = source ? find_value(whole_of(source), list) : (span){0};
    span table = rows.line > 0 ? find_row(rows, row) : rows;
    int line = table.line > 0 && name ? find_value(table, name).line : 0;
    return line > 0 ? line : table.line;
}

// ---------------------------------------------------------------- errors

static int raise(lua_State *L, int line, const char *format, va_list args)
{
    const char *file = NULL;
    const char *source = script_chunk(L, &file);
    lua_Debug caller;
    char message[1000];
    vsnprintf(message, sizeof message, format, args);
    if (lua_getstack(L, 1, &caller) || !source)
        return luaL_error(L, "%s", message);
    if (line > 0)
        lua_pushfstring(L, "%s:%d: %s", file, line, message);
    else
        lua_pushfstring(L, "%s: %s", file, message);
    return lua_error(L);
}

int field_raise(lua_State *L, const char *name, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int line = name ? field_line(L, name) : 0;
    raise(L, line, format, args); // does not return
    va_end(args);
    return 0;
}

int field_raise_at(lua_State *L, int line, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    raise(L, line, format, args); // does not return
    va_end(args);
    return 0;
}
