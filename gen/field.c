// SPDX-License-Identifier: MIT
// A table does not know the line it was written at. The line is looked for in
// the script's text instead, and told only if there is exactly one.
#define _GNU_SOURCE // memmem
#include "gen/field.h"
#include "gen/script.h"

#include <ctype.h>
#include <lauxlib.h>
#include <math.h>
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
    return line_of(script_chunk(L, &file), name);
}

int field_raise(lua_State *L, const char *name, const char *format, ...)
{
    const char *file = NULL;
    script_chunk(L, &file);
    int line = name ? field_line(L, name) : 0;
    char message[400];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    if (line > 0)
        lua_pushfstring(L, "%s:%d: %s", file, line, message);
    else
        lua_pushfstring(L, "%s: %s", file, message);
    return lua_error(L);
}

static bool is_listed(const char *name, const char *const *names)
{
    while (*names && strcmp(*names, name) != 0)
        ++names;
    return *names;
}

static void raise_unknown(lua_State *L, const char *what, const char *name,
                          const char *const *names)
{
    char all[300] = "";
    for (size_t used = 0; *names && used < sizeof all; ++names)
        used += (size_t)snprintf(all + used, sizeof all - used, "%s%s", used ? ", " : "", *names);
    field_raise(L, name, "%s has no field '%s': there are %s", what, name, all);
}

void field_only(lua_State *L, int table, const char *what, const char *const *names)
{
    table = lua_absindex(L, table);
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING) {
            lua_pushvalue(L, -2);
            field_raise(L, NULL, "%s has no field [%s]: its fields have names", what,
                        script_tostring(L, -1, NULL));
        }
        if (!is_listed(lua_tostring(L, -2), names))
            raise_unknown(L, what, lua_tostring(L, -2), names);
    }
}

// Says what the value on top is and what it should be.
static void raise_type(lua_State *L, const char *name, const char *wanted)
{
    if (lua_type(L, -1) == LUA_TSTRING)
        field_raise(L, name, "%s must be %s, is '%s'", name, wanted, lua_tostring(L, -1));
    if (lua_type(L, -1) == LUA_TNUMBER)
        field_raise(L, name, "%s must be %s, is %s", name, wanted, lua_tostring(L, -1));
    field_raise(L, name, "%s must be %s, is a %s", name, wanted, luaL_typename(L, -1));
}

bool field_boolean(lua_State *L, int table, const char *name, bool fallback)
{
    int type = lua_getfield(L, table, name);
    if (type != LUA_TNIL && type != LUA_TBOOLEAN)
        raise_type(L, name, "true or false");
    bool value = type == LUA_TNIL ? fallback : lua_toboolean(L, -1);
    lua_pop(L, 1);
    return value;
}

double field_number(lua_State *L, int table, const char *name, double fallback)
{
    int type = lua_getfield(L, table, name);
    if (type != LUA_TNIL && (type != LUA_TNUMBER || !isfinite(lua_tonumber(L, -1))))
        raise_type(L, name, "a finite number");
    double value = type == LUA_TNIL ? fallback : lua_tonumber(L, -1);
    lua_pop(L, 1);
    return value;
}

int64_t field_integer(lua_State *L, int table, const char *name, int64_t fallback)
{
    int type = lua_getfield(L, table, name);
    int whole = 0;
    int64_t value = lua_tointegerx(L, -1, &whole);
    if (type != LUA_TNIL && (type != LUA_TNUMBER || !whole))
        raise_type(L, name, "a whole number");
    lua_pop(L, 1);
    return type == LUA_TNIL ? fallback : value;
}

const char *field_string(lua_State *L, int table, const char *name, const char *fallback)
{
    int type = lua_getfield(L, table, name);
    if (type != LUA_TNIL && type != LUA_TSTRING)
        raise_type(L, name, "a text in quotes");
    const char *value = type == LUA_TNIL ? fallback : lua_tostring(L, -1);
    lua_pop(L, 1);
    return value;
}

bool field_push(lua_State *L, int table, const char *name, int type)
{
    int found = lua_getfield(L, table, name);
    if (found == type)
        return true;
    if (found != LUA_TNIL)
        raise_type(L, name, type == LUA_TTABLE ? "a table" : "a function");
    lua_pop(L, 1);
    return false;
}
