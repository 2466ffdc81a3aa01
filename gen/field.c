// SPDX-License-Identifier: MIT
#include "gen/field.h"

#include "base/visible.h"

#include <lauxlib.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- messages

const char *field_text(lua_State *L, int index)
{
    const char *chars = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : NULL;
    return chars && strlen(chars) == lua_rawlen(L, index) ? chars : NULL;
}

// Cuts and shows the text on top of the stack in place.
static const char *show_text(lua_State *L)
{
    enum { MOST = 100 };
    luaL_Buffer line;
    size_t n = 0, at = 0;
    const char *chars = lua_tolstring(L, -1, &n);
    luaL_buffinit(L, &line);
    while (at < n && at < MOST) {
        char shown[VISIBLE_MOST];
        at += visible_show(chars + at, n - at, "\n\r\t", shown);
        luaL_addstring(&line, shown);
    }
    luaL_addstring(&line, at < n ? "..." : "");
    luaL_pushresult(&line);
    lua_remove(L, -2);
    return lua_tostring(L, -1);
}

void field_push_raw(lua_State *L, int index)
{
    if (lua_isnil(L, index))
        lua_pushstring(L, "nil");
    else if (lua_isboolean(L, index))
        lua_pushstring(L, lua_toboolean(L, index) ? "true" : "false");
    else
        lua_pushvalue(L, index);
    lua_tostring(L, -1); // makes a number a string in place
}

const char *field_push_shown(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) > LUA_TSTRING || lua_islightuserdata(L, index))
        return lua_pushfstring(L, "a %s", luaL_typename(L, index));
    field_push_raw(L, index);
    return show_text(L);
}

const char *field_push_names(lua_State *L, const char *(*name_of)(int value))
{
    luaL_Buffer known;
    luaL_buffinit(L, &known);
    for (int i = 0; name_of(i); ++i) {
        luaL_addstring(&known, i ? ", " : "");
        luaL_addstring(&known, name_of(i));
    }
    luaL_pushresult(&known);
    return lua_tostring(L, -1);
}

// Names the object that the message is about, if there are several: "object 3: "; else nothing.
static const char *push_prefix(lua_State *L, const field_table *table, const char *after)
{
    if (!table)
        return lua_pushstring(L, "");
    if (table->row < 0)
        return lua_pushfstring(L, "%s%s", table->name, after);
    return lua_pushfstring(L, "%s %I%s", table->name, (LUAI_UACINT)table->row, after);
}

// The line that gives the name its value in the table, or else that of the table: "x" of "args.x".
static int line_in(lua_State *L, const field_table *table, const char *name)
{
    int line = table && table->list ? field_line_in_row(L, table->list, table->row, name) : 0;
    if (line == 0 && name)
        line = field_line(L, name);
    if (line > 0 || !table)
        return line;
    const char *point = strrchr(table->name, '.');
    return field_line(L, table->list ? table->list : point ? point + 1 : table->name);
}

int field_raise_in(lua_State *L, const field_table *table, const char *name, const char *format,
                   ...)
{
    char message[1000];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    return field_raise_at(L, line_in(L, table, name), "%s%s", push_prefix(L, table, ": "), message);
}

// Pushes the value on top as a message shows it: 'x', 1.5, "a list of 4", "a table".
static const char *push_quoted(lua_State *L)
{
    if (lua_istable(L, -1) && lua_rawlen(L, -1) > 0)
        return lua_pushfstring(L, "a list of %I", (LUAI_UACINT)lua_rawlen(L, -1));
    const char *shown = field_push_shown(L, -1);
    return lua_type(L, -2) == LUA_TSTRING ? lua_pushfstring(L, "'%s'", shown) : shown;
}

int field_refuse(lua_State *L, const field *f, const char *expected)
{
    const char *value = push_quoted(L);
    return field_raise_in(L, f->table, f->name, "%s is %s; expected %s", f->name, value,
                          f->expected ? f->expected : expected);
}

// ---------------------------------------------------------------- texts

// A number is not taken: lua_tostring would make a string that only the stack holds.
static const char *take_text(lua_State *L, const field *f)
{
    const char *chars = field_text(L, -1);
    if (!chars)
        field_refuse(L, f, lua_type(L, -1) == LUA_TSTRING ? "a string without NUL" : "a string");
    return chars;
}

static void read_string(lua_State *L, const field *f, void *at)
{
    *(const char **)at = take_text(L, f);
}

static void push_string(lua_State *L, const field *f, const void *at)
{
    (void)f;
    lua_pushstring(L, *(const char *const *)at);
}

static void read_chars(lua_State *L, const field *f, void *at)
{
    const char *chars = take_text(L, f);
    size_t length = strlen(chars);
    if (length >= f->size)
        field_raise_in(L, f->table, f->name, "%s has %zu characters; expected at most %zu", f->name,
                       length, f->size - 1);
    memcpy(at, chars, length + 1);
}

static void push_chars(lua_State *L, const field *f, const void *at)
{
    (void)f;
    lua_pushstring(L, at);
}

// The value whose name is on top of the stack.
static int take_enum(lua_State *L, const field *f)
{
    const char *name = field_text(L, -1);
    int value = 0;
    while (f->name_of(value) && (!name || strcmp(name, f->name_of(value)) != 0))
        ++value;
    if (!f->name_of(value)) {
        const char *expected = lua_pushfstring(L, "one of %s", field_push_names(L, f->name_of));
        lua_pushvalue(L, -3);
        field_refuse(L, f, expected);
    }
    return value;
}

static void read_enum(lua_State *L, const field *f, void *at)
{
    int value = take_enum(L, f);
    memcpy(at, &value, sizeof value); // an enum of ours is an int
}

static void read_enums(lua_State *L, const field *f, void *at)
{
    field_enum_list *list = at;
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (n > FIELD_NAMES)
        field_refuse(L, f, "a list of 1 to 32 names");
    for (list->n = 0; list->n < n; lua_pop(L, 1)) {
        lua_rawgeti(L, -1, (lua_Integer)list->n + 1);
        list->values[list->n++] = take_enum(L, f);
    }
    if (n == 0)
        list->values[list->n++] = take_enum(L, f);
}

static void push_enum(lua_State *L, const field *f, const void *at)
{
    int value = 0;
    memcpy(&value, at, sizeof value);
    lua_pushstring(L, f->name_of(value));
}

// ---------------------------------------------------------------- numbers

static void read_bool(lua_State *L, const field *f, void *at)
{
    if (!lua_isboolean(L, -1))
        field_refuse(L, f, "true or false");
    *(bool *)at = lua_toboolean(L, -1);
}

static void push_bool(lua_State *L, const field *f, const void *at)
{
    (void)f;
    lua_pushboolean(L, *(const bool *)at);
}

// Whether the row has a range that the value is out of; NaN is out of any.
static bool is_outside(const field *f, double value)
{
    return (f->least != 0 || f->most != 0) && !(value >= f->least && value <= f->most);
}

static int64_t take_whole(lua_State *L, const field *f, int64_t least, int64_t most,
                          const char *expected)
{
    int is_whole = 0;
    lua_Integer value = lua_tointegerx(L, -1, &is_whole);
    if (lua_type(L, -1) != LUA_TNUMBER || !is_whole || value < least || value > most ||
        is_outside(f, (double)value))
        field_refuse(L, f, expected);
    return value;
}

static void read_count(lua_State *L, const field *f, void *at)
{
    int64_t most = f->size == 8 ? INT64_MAX : UINT32_MAX;
    int64_t value = take_whole(L, f, 0, most, "a whole number from 0");
    if (f->size == 8)
        *(uint64_t *)at = (uint64_t)value;
    else
        *(uint32_t *)at = (uint32_t)value;
}

static void read_int(lua_State *L, const field *f, void *at)
{
    if (f->size == 8)
        *(int64_t *)at = take_whole(L, f, INT64_MIN, INT64_MAX, "a whole number");
    else
        *(int32_t *)at = (int32_t)take_whole(L, f, INT32_MIN, INT32_MAX, "a whole number");
}

static void push_count(lua_State *L, const field *f, const void *at)
{
    if (f->size == 8)
        lua_pushinteger(L, (lua_Integer) * (const uint64_t *)at);
    else
        lua_pushinteger(L, *(const uint32_t *)at);
}

static void push_int(lua_State *L, const field *f, const void *at)
{
    if (f->size == 8)
        lua_pushinteger(L, *(const int64_t *)at);
    else
        lua_pushinteger(L, *(const int32_t *)at);
}

static lua_Number take_number(lua_State *L, const field *f)
{
    lua_Number value = lua_tonumber(L, -1);
    if (lua_type(L, -1) != LUA_TNUMBER || is_outside(f, value))
        field_refuse(L, f, f->most != 0 ? "a finite number" : "a number");
    return value;
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
static void read_numbers(lua_State *L, const field *f, void *at, size_t bytes)
{
    size_t n = f->size / bytes;
    if (n <= 1) {
        set_number(at, 0, take_number(L, f), bytes);
        return;
    }
    lua_Unsigned given = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (given != n && given != 2)
        field_refuse(L, f, "{ x, y, z } (in 2D { x, y })");
    memset(at, 0, f->size);
    for (size_t i = 0; i < given; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        set_number(at, i, take_number(L, f), bytes);
        lua_pop(L, 1);
    }
}

static void read_float(lua_State *L, const field *f, void *at)
{
    read_numbers(L, f, at, sizeof(float));
}

static void read_double(lua_State *L, const field *f, void *at)
{
    read_numbers(L, f, at, sizeof(double));
}

// Pushes several fields of one type as a sequence, and one as its value.
#define PUSH_SEVERAL(name, type, push_one)                         \
    static void name(lua_State *L, const field *f, const void *at) \
    {                                                              \
        size_t n = f->size / sizeof(type);                         \
        if (n == 1) {                                              \
            push_one(L, *(const type *)at);                        \
            return;                                                \
        }                                                          \
        lua_createtable(L, (int)n, 0);                             \
        for (size_t i = 0; i < n; ++i) {                           \
            push_one(L, ((const type *)at)[i]);                    \
            lua_rawseti(L, -2, (lua_Integer)i + 1);                \
        }                                                          \
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
static void push_double(lua_State *L, const field *f, const void *at)
{
    if (f->size == sizeof(double) && isnan(*(const double *)at))
        lua_pushnil(L);
    else
        push_doubles(L, f, at);
}

static void read_names(lua_State *L, const field *f, void *at)
{
    field_name_list *list = at;
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (n < 1 || n > FIELD_NAMES)
        field_refuse(L, f, "a list of 1 to 32 names");
    for (list->n = 0; list->n < n; ++list->n) {
        lua_rawgeti(L, -1, (lua_Integer)list->n + 1);
        list->names[list->n] = field_text(L, -1);
        if (!list->names[list->n])
            field_refuse(L, f, "a list of names");
        lua_pop(L, 1);
    }
}

static void read_function(lua_State *L, const field *f, void *at)
{
    if (!lua_isfunction(L, -1))
        field_refuse(L, f, "a function");
    *(bool *)at = true;
}

static void read_nothing(lua_State *L, const field *f, void *at)
{
    (void)L, (void)f, (void)at;
}

const field_type field_string = {.read = read_string, .push = push_string};
const field_type field_chars = {.read = read_chars, .push = push_chars};
const field_type field_bool = {.read = read_bool, .push = push_bool};
const field_type field_count = {.read = read_count, .push = push_count};
const field_type field_int = {.read = read_int, .push = push_int};
const field_type field_float = {.read = read_float, .push = push_float};
const field_type field_double = {.read = read_double, .push = push_double};
const field_type field_counts = {.push = push_counts};
const field_type field_sizes = {.push = push_sizes};
const field_type field_enum = {.read = read_enum, .push = push_enum};
const field_type field_enums = {.read = read_enums};
const field_type field_names = {.read = read_names};
const field_type field_function = {.read = read_function};
const field_type field_unread = {.read = read_nothing};

// ---------------------------------------------------------------- tables

const field *field_named(const field *fields, const char *name)
{
    for (const field *f = fields; f->name; ++f)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

bool field_is_given(const field *fields, uint64_t given, const char *name)
{
    return given >> (field_named(fields, name) - fields) & 1;
}

// Pushes "a, b, c".
static const char *push_field_names(lua_State *L, const field *fields)
{
    luaL_Buffer names;
    luaL_buffinit(L, &names);
    for (const field *f = fields; f->name; ++f) {
        luaL_addstring(&names, f == fields ? "" : ", ");
        luaL_addstring(&names, f->name);
    }
    luaL_pushresult(&names);
    return lua_tostring(L, -1);
}

// Raises; the key is on top.
static void refuse_key(lua_State *L, const char *what, const field_table *table,
                       const field *fields)
{
    const char *name = field_text(L, -1);
    bool quoted = lua_type(L, -1) == LUA_TSTRING;
    const char *key = field_push_shown(L, -1);
    const char *whole = table ? push_prefix(L, table, "") : what;
    field_raise_at(L, line_in(L, table, name),
                   quoted ? "%s has no field '%s'; its fields are %s"
                          : "%s has no field [%s]; its fields are %s",
                   whole, key, push_field_names(L, fields));
}

// The value at index is one of several and should be a table.
static void refuse_table(lua_State *L, int index, const field_table *table, const field *fields)
{
    lua_pushvalue(L, index);
    const char *value = push_quoted(L);
    const char *whole = push_prefix(L, table, "");
    field_raise_at(L, line_in(L, table, NULL), "%s is %s; expected a table of %s", whole, value,
                   push_field_names(L, fields));
}

// The row of the key at index, which may be a string with any bytes; NULL: none.
static const field *find_key(lua_State *L, int index, const field *fields)
{
    if (lua_isinteger(L, index)) {
        char name[32];
        snprintf(name, sizeof name, "[%lld]", (long long)lua_tointeger(L, index));
        return field_named(fields, name);
    }
    const char *name = field_text(L, index);
    return name && *name != '[' ? field_named(fields, name) : NULL;
}

bool field_read_one(lua_State *L, int index, const field *f, void *to)
{
    index = lua_absindex(L, index);
    if (*f->name == '[') {
        lua_rawgeti(L, index, strtol(f->name + 1, NULL, 10));
    } else {
        lua_pushstring(L, f->name);
        lua_rawget(L, index);
    }
    bool given = !lua_isnil(L, -1);
    if (given)
        f->type->read(L, f, (char *)to + f->offset);
    lua_pop(L, 1);
    return given;
}

// Whether the key at index a is shown before that at b, an absolute index; true if that is nil.
static bool is_shown_before(lua_State *L, int a, int b)
{
    bool before = lua_isnil(L, b);
    if (!before) {
        const char *first = field_push_shown(L, a);
        before = strcmp(first, field_push_shown(L, b)) < 0;
        lua_pop(L, 2);
    }
    return before;
}

// Finds which fields the table has, and leaves on top the first key in the alphabet that is none,
// or nil: Lua's own order changes from run to run.
static uint64_t find_fields(lua_State *L, int index, const field *fields)
{
    uint64_t given = 0;
    lua_pushnil(L);
    int unknown = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        const field *f = find_key(L, -2, fields);
        if (f) {
            given |= UINT64_C(1) << (f - fields);
        } else if (is_shown_before(L, -2, unknown)) {
            lua_pushvalue(L, -2);
            lua_replace(L, unknown);
        }
    }
    return given;
}

static uint64_t read_fields(lua_State *L, int index, const char *what, const field_table *table,
                            const field *fields, void *to)
{
    if (lua_isnoneornil(L, index) && !table)
        return 0;
    index = lua_absindex(L, index);
    if (table && !lua_istable(L, index))
        refuse_table(L, index, table, fields);
    luaL_checktype(L, index, LUA_TTABLE);
    luaL_checkstack(L, 16, "too many tables in tables");
    uint64_t given = find_fields(L, index, fields);
    if (!lua_isnil(L, -1))
        refuse_key(L, what, table, fields);
    lua_pop(L, 1);
    for (uint64_t left = given; left; left &= left - 1) {
        field f = fields[__builtin_ctzll(left)];
        f.table = table;
        field_read_one(L, index, &f, to);
    }
    return given;
}

uint64_t field_read(lua_State *L, int index, const char *what, const field *fields, void *to)
{
    return read_fields(L, index, what, NULL, fields, to);
}

uint64_t field_read_row(lua_State *L, int index, field_table table, const field *fields, void *to)
{
    return read_fields(L, index, NULL, &table, fields, to);
}

void field_push(lua_State *L, const field *f, const void *from)
{
    f->type->push(L, f, (const char *)from + f->offset);
}

void field_push_table(lua_State *L, const field *fields, const void *from)
{
    lua_newtable(L);
    for (const field *f = fields; f->name; ++f) {
        field_push(L, f, from);
        lua_setfield(L, -2, f->name);
    }
}

void field_read_struct(lua_State *L, const field *f, void *at)
{
    if (!lua_istable(L, -1)) {
        const char *names = push_field_names(L, f->type->fields);
        const char *expected = lua_pushfstring(L, "a table of %s", names);
        lua_pushvalue(L, -3);
        field_refuse(L, f, expected);
    }
    field_read(L, -1, f->type->what, f->type->fields, at);
}

void field_push_struct(lua_State *L, const field *f, const void *at)
{
    field_push_table(L, f->type->fields, at);
}

void field_push_list(lua_State *L, const field *fields, const void *from, uint64_t n, size_t size)
{
    lua_createtable(L, (int)n, 0);
    for (uint64_t i = 0; i < n; ++i) {
        field_push_table(L, fields, (const char *)from + i * size);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}
