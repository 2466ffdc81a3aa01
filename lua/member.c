// SPDX-License-Identifier: MIT
#include "lua/member.h"

#include "runtime/duet.h"

#include <lauxlib.h>
#include <math.h>
#include <string.h>

const char *member_push_shown(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) <= LUA_TSTRING && !lua_islightuserdata(L, index))
        return luaL_tolstring(L, index, NULL);
    return lua_pushfstring(L, "a %s", luaL_typename(L, index));
}

int member_refuse(lua_State *L, const member *m, const char *wanted)
{
    if (lua_type(L, -1) == LUA_TNUMBER)
        return luaL_error(L, "field '%s': %s, not %s", m->name, luaL_tolstring(L, -1, NULL),
                          wanted);
    return luaL_error(L, "field '%s': a %s, not %s", m->name, luaL_typename(L, -1), wanted);
}

// ---------------------------------------------------------------- texts

// A number is not taken: lua_tostring would make a string that only the stack holds.
static void read_string(lua_State *L, const member *m, void *at)
{
    if (lua_type(L, -1) != LUA_TSTRING)
        member_refuse(L, m, "a string");
    *(const char **)at = lua_tostring(L, -1);
}

static void push_string(lua_State *L, const member *m, const void *at)
{
    (void)m;
    lua_pushstring(L, *(const char *const *)at);
}

static void read_chars(lua_State *L, const member *m, void *at)
{
    size_t length = 0;
    if (lua_type(L, -1) != LUA_TSTRING)
        member_refuse(L, m, "a string");
    const char *chars = lua_tolstring(L, -1, &length);
    if (length >= m->size)
        luaL_error(L, "field '%s': %d characters, and %d are the most", m->name, (int)length,
                   (int)m->size - 1);
    memcpy(at, chars, length + 1);
}

static void push_chars(lua_State *L, const member *m, const void *at)
{
    (void)m;
    lua_pushstring(L, at);
}

// Raises an error that lists the names.
static void refuse_name(lua_State *L, const member *m, const char *name)
{
    luaL_Buffer known;
    luaL_buffinit(L, &known);
    for (int i = 0; m->name_of(i); ++i) {
        luaL_addstring(&known, i ? ", " : "");
        luaL_addstring(&known, m->name_of(i));
    }
    luaL_pushresult(&known);
    luaL_error(L, "field '%s': '%s'; expected one of %s", m->name, name, lua_tostring(L, -1));
}

static void read_enum(lua_State *L, const member *m, void *at)
{
    const char *name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : luaL_typename(L, -1);
    int value = 0;
    while (m->name_of(value) && strcmp(name, m->name_of(value)) != 0)
        ++value;
    if (!m->name_of(value))
        refuse_name(L, m, name);
    memcpy(at, &value, sizeof value); // an enum of ours is an int
}

static void push_enum(lua_State *L, const member *m, const void *at)
{
    int value = 0;
    memcpy(&value, at, sizeof value);
    lua_pushstring(L, m->name_of(value));
}

// ---------------------------------------------------------------- numbers

static void read_bool(lua_State *L, const member *m, void *at)
{
    if (!lua_isboolean(L, -1))
        member_refuse(L, m, "true or false");
    *(bool *)at = lua_toboolean(L, -1);
}

static void push_bool(lua_State *L, const member *m, const void *at)
{
    (void)m;
    lua_pushboolean(L, *(const bool *)at);
}

static void read_count(lua_State *L, const member *m, void *at)
{
    int is_whole = 0;
    lua_Integer value = lua_tointegerx(L, -1, &is_whole);
    bool fits = m->size == 8 || value <= UINT32_MAX;
    if (lua_type(L, -1) != LUA_TNUMBER || !is_whole || value < 0 || !fits)
        member_refuse(L, m, "a whole number from 0");
    if (m->size == 8)
        *(uint64_t *)at = (uint64_t)value;
    else
        *(uint32_t *)at = (uint32_t)value;
}

static void push_count(lua_State *L, const member *m, const void *at)
{
    if (m->size == 8)
        lua_pushinteger(L, (lua_Integer) * (const uint64_t *)at);
    else
        lua_pushinteger(L, *(const uint32_t *)at);
}

static void push_int(lua_State *L, const member *m, const void *at)
{
    if (m->size == 8)
        lua_pushinteger(L, *(const int64_t *)at);
    else
        lua_pushinteger(L, *(const int32_t *)at);
}

static void read_share(lua_State *L, const member *m, void *at)
{
    lua_Number share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        member_refuse(L, m, "a part from 0 to 1");
    *(uint32_t *)at = (uint32_t)lround(share * DUET_SHARE_ONE);
}

static void push_share(lua_State *L, const member *m, const void *at)
{
    (void)m;
    lua_pushnumber(L, (lua_Number) * (const uint32_t *)at / DUET_SHARE_ONE);
}

static lua_Number take_number(lua_State *L, const member *m)
{
    if (lua_type(L, -1) != LUA_TNUMBER)
        member_refuse(L, m, "a number");
    return lua_tonumber(L, -1);
}

// Puts number i of floats or of doubles, as bytes says.
static void set_number(void *at, size_t i, lua_Number value, size_t bytes)
{
    if (bytes == sizeof(double))
        ((double *)at)[i] = value;
    else
        ((float *)at)[i] = (float)value;
}

// One number, or a table of two (in 2D) or of as many as there are.
static void read_numbers(lua_State *L, const member *m, void *at, size_t bytes)
{
    size_t n = m->size / bytes;
    if (n == 1) {
        set_number(at, 0, take_number(L, m), bytes);
        return;
    }
    lua_Unsigned given = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (given != n && given != 2)
        member_refuse(L, m, "{ x, y, z } (in 2D { x, y })");
    memset(at, 0, m->size);
    for (size_t i = 0; i < given; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        set_number(at, i, take_number(L, m), bytes);
        lua_pop(L, 1);
    }
}

static void read_float(lua_State *L, const member *m, void *at)
{
    read_numbers(L, m, at, sizeof(float));
}

static void read_double(lua_State *L, const member *m, void *at)
{
    read_numbers(L, m, at, sizeof(double));
}

// Pushes several members of one type as a sequence, and one as its value.
#define PUSH_SEVERAL(name, type, push_one)                          \
    static void name(lua_State *L, const member *m, const void *at) \
    {                                                               \
        size_t n = m->size / sizeof(type);                          \
        if (n == 1) {                                               \
            push_one(L, *(const type *)at);                         \
            return;                                                 \
        }                                                           \
        lua_createtable(L, (int)n, 0);                              \
        for (size_t i = 0; i < n; ++i) {                            \
            push_one(L, ((const type *)at)[i]);                     \
            lua_rawseti(L, -2, (lua_Integer)i + 1);                 \
        }                                                           \
    }

static void push_size(lua_State *L, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)value);
}

PUSH_SEVERAL(push_float, float, lua_pushnumber)
PUSH_SEVERAL(push_doubles, double, lua_pushnumber)
PUSH_SEVERAL(push_counts, uint32_t, lua_pushinteger)
PUSH_SEVERAL(push_sizes, uint64_t, push_size)

// A figure that was not measured is NaN in C and nil in Lua.
static void push_double(lua_State *L, const member *m, const void *at)
{
    if (m->size == sizeof(double) && isnan(*(const double *)at))
        lua_pushnil(L);
    else
        push_doubles(L, m, at);
}

const member_type member_string = {.read = read_string, .push = push_string};
const member_type member_chars = {.read = read_chars, .push = push_chars};
const member_type member_bool = {.read = read_bool, .push = push_bool};
const member_type member_count = {.read = read_count, .push = push_count};
const member_type member_int = {.push = push_int};
const member_type member_float = {.read = read_float, .push = push_float};
const member_type member_double = {.read = read_double, .push = push_double};
const member_type member_counts = {.push = push_counts};
const member_type member_sizes = {.push = push_sizes};
const member_type member_share = {.read = read_share, .push = push_share};
const member_type member_enum = {.read = read_enum, .push = push_enum};

// ---------------------------------------------------------------- tables

const member *member_find(const member *members, const char *name)
{
    for (const member *f = members; f->name; ++f)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

// Raises; the key is at -2.
static void refuse_key(lua_State *L, const char *what, const member *members)
{
    const char *key = member_push_shown(L, -2);
    luaL_Buffer known;
    luaL_buffinit(L, &known);
    for (const member *f = members; f->name; ++f) {
        luaL_addstring(&known, f == members ? "" : ", ");
        luaL_addstring(&known, f->name);
    }
    luaL_pushresult(&known);
    luaL_error(L, "%s has no field '%s'; its fields are %s", what, key, lua_tostring(L, -1));
}

void member_read_table(lua_State *L, int index, const char *what, const member *members, void *to)
{
    if (lua_isnoneornil(L, index))
        return;
    index = lua_absindex(L, index);
    luaL_checktype(L, index, LUA_TTABLE);
    luaL_checkstack(L, 8, "too many tables in tables");
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        bool named = lua_type(L, -2) == LUA_TSTRING;
        const member *f = named ? member_find(members, lua_tostring(L, -2)) : NULL;
        if (!f)
            refuse_key(L, what, members);
        else
            f->type->read(L, f, (char *)to + f->offset);
    }
}

void member_push(lua_State *L, const member *m, const void *from)
{
    m->type->push(L, m, (const char *)from + m->offset);
}

void member_push_table(lua_State *L, const member *members, const void *from)
{
    lua_newtable(L);
    for (const member *f = members; f->name; ++f) {
        member_push(L, f, from);
        lua_setfield(L, -2, f->name);
    }
}

void member_read_struct(lua_State *L, const member *m, void *at)
{
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a table");
    member_read_table(L, -1, m->type->what, m->type->members, at);
}

void member_push_struct(lua_State *L, const member *m, const void *at)
{
    member_push_table(L, m->type->members, at);
}

void member_push_list(lua_State *L, const member *members, const void *from, uint64_t n,
                      size_t size)
{
    lua_createtable(L, (int)n, 0);
    for (uint64_t i = 0; i < n; ++i) {
        member_push_table(L, members, (const char *)from + i * size);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}
