// SPDX-License-Identifier: MIT
#include "lua/array.h"

#include "lua/class.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

_Static_assert(sizeof(duet_pose) == 10 * sizeof(float), "a pose is ten floats");
_Static_assert(sizeof(duet_bounds) == 6 * sizeof(float), "bounds are six floats");
_Static_assert(sizeof(duet_pair) == 2 * sizeof(uint32_t), "a pair is two ids");

static const lua_class classes[3];

// Numbers in a row, all of four bytes.
static const int columns[] = {[ARRAY_POSES] = 10, [ARRAY_BOUNDS] = 6, [ARRAY_PAIRS] = 2};

static size_t row_bytes(const array *a)
{
    return (size_t)columns[a->kind] * 4;
}

static void *row_at(const array *a, uint64_t i)
{
    return (char *)a->rows + i * row_bytes(a);
}

// ---------------------------------------------------------------- making

array *array_push_empty(lua_State *L, array_kind kind)
{
    array *a = class_push(L, &classes[kind], sizeof *a);
    a->kind = kind;
    return a;
}

array *array_push(lua_State *L, array_kind kind, uint64_t n)
{
    uint64_t most = (SIZE_MAX / 2 - sizeof(array)) / ((uint64_t)columns[kind] * 4);
    if (n > most)
        luaL_error(L, "%s of %I rows: too many", classes[kind].name, (LUAI_UACINT)n);
    array *a = class_push(L, &classes[kind], sizeof *a + n * (size_t)columns[kind] * 4);
    a->kind = kind;
    a->rows = a + 1;
    a->n = n;
    return a;
}

array *array_push_view(lua_State *L, array_kind kind, void *rows, uint64_t n, int owner_index,
                       const uint64_t *epoch)
{
    owner_index = lua_absindex(L, owner_index);
    array *a = array_push_empty(L, kind);
    lua_pushvalue(L, owner_index);
    lua_setiuservalue(L, -2, 1);
    a->rows = rows;
    a->n = n;
    a->epoch = epoch;
    a->epoch_made = *epoch;
    return a;
}

// Writes the number on top of the stack into a row's column, and pops it.
static void take_column(lua_State *L, const array *a, uint64_t i, int column)
{
    int is_number = 0;
    if (a->kind == ARRAY_PAIRS) {
        lua_Integer id = lua_tointegerx(L, -1, &is_number);
        if (!is_number || id < 0 || id > UINT32_MAX)
            luaL_error(L, "%s: row %I: an id is a whole number from 0", classes[a->kind].name,
                       (LUAI_UACINT)i);
        ((uint32_t *)row_at(a, i))[column] = (uint32_t)id;
    } else {
        lua_Number number = lua_tonumberx(L, -1, &is_number);
        if (!is_number)
            luaL_error(L, "%s: row %I, column %d: a %s, not a number", classes[a->kind].name,
                       (LUAI_UACINT)i, column + 1, luaL_typename(L, -1));
        ((float *)row_at(a, i))[column] = (float)number;
    }
    lua_pop(L, 1);
}

static void read_row(lua_State *L, int index, const array *a, uint64_t i)
{
    int width = columns[a->kind];
    lua_Unsigned given = lua_istable(L, index) ? lua_rawlen(L, index) : 0;
    if (given != (lua_Unsigned)width)
        luaL_error(L, "%s: row %I: %I numbers, and a row has %d", classes[a->kind].name,
                   (LUAI_UACINT)i, (LUAI_UACINT)given, width);
    for (int column = 0; column < width; ++column) {
        lua_rawgeti(L, index, column + 1);
        take_column(L, a, i, column);
    }
}

static void push_from_rows(lua_State *L, int index, array_kind kind)
{
    lua_Unsigned n = lua_rawlen(L, index);
    array *a = array_push(L, kind, n);
    for (lua_Unsigned i = 0; i < n; ++i) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        read_row(L, lua_gettop(L), a, i);
        lua_pop(L, 1);
    }
}

static void push_from_numbers(lua_State *L, int index, array_kind kind)
{
    lua_Unsigned numbers = lua_rawlen(L, index);
    lua_Unsigned width = (lua_Unsigned)columns[kind];
    if (numbers % width != 0)
        luaL_error(L, "%s from %I numbers: a row has %d", classes[kind].name, (LUAI_UACINT)numbers,
                   columns[kind]);
    array *a = array_push(L, kind, numbers / width);
    for (lua_Unsigned i = 0; i < numbers; ++i) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        take_column(L, a, i / width, (int)(i % width));
    }
}

static void push_from_bytes(lua_State *L, int index, array_kind kind)
{
    size_t length = 0;
    const char *bytes = lua_tolstring(L, index, &length);
    size_t width = (size_t)columns[kind] * 4;
    if (length % width != 0)
        luaL_error(L, "%s from %I bytes: a row has %d", classes[kind].name, (LUAI_UACINT)length,
                   (int)width);
    array *a = array_push(L, kind, length / width);
    memcpy(a->rows, bytes, length);
}

static void push_from_value(lua_State *L, int index, array_kind kind)
{
    if (lua_type(L, index) == LUA_TSTRING) {
        push_from_bytes(L, index, kind);
        return;
    }
    luaL_checktype(L, index, LUA_TTABLE);
    bool by_row = lua_rawgeti(L, index, 1) == LUA_TTABLE;
    lua_pop(L, 1);
    if (by_row)
        push_from_rows(L, index, kind);
    else
        push_from_numbers(L, index, kind);
}

// n rows: boxes without size at the origin, not turned.
static void push_blank(lua_State *L, array_kind kind, lua_Integer n)
{
    luaL_argcheck(L, n >= 0, 1, "a count from 0");
    array *a = array_push(L, kind, (uint64_t)n);
    for (uint64_t i = 0; kind == ARRAY_POSES && i < a->n; ++i)
        ((duet_pose *)a->rows)[i].rotation[3] = 1;
}

static int make(lua_State *L, array_kind kind)
{
    if (lua_type(L, 1) == LUA_TNUMBER)
        push_blank(L, kind, luaL_checkinteger(L, 1));
    else
        push_from_value(L, 1, kind);
    return 1;
}

static int make_poses(lua_State *L)
{
    return make(L, ARRAY_POSES);
}

static int make_bounds(lua_State *L)
{
    return make(L, ARRAY_BOUNDS);
}

static int make_pairs(lua_State *L)
{
    return make(L, ARRAY_PAIRS);
}

// ---------------------------------------------------------------- reading

static array *test_array(lua_State *L, int index)
{
    for (int kind = 0; kind < 3; ++kind) {
        array *a = luaL_testudata(L, index, classes[kind].name);
        if (a)
            return a;
    }
    return NULL;
}

static void check_alive(lua_State *L, int index, const array *a)
{
    luaL_argcheck(L, a->rows || a->n == 0, index, "the array is closed");
    luaL_argcheck(L, !a->epoch || *a->epoch == a->epoch_made, index,
                  "the view is of memory that its owner has given back");
}

static array *check_self(lua_State *L)
{
    array *a = test_array(L, 1);
    if (!a)
        luaL_typeerror(L, 1, "duet.poses, duet.bounds or duet.pairs");
    check_alive(L, 1, a);
    return a;
}

const array *array_check(lua_State *L, int index, array_kind kind)
{
    index = lua_absindex(L, index);
    if (!lua_isuserdata(L, index)) {
        push_from_value(L, index, kind);
        lua_replace(L, index);
    }
    const array *a = luaL_checkudata(L, index, classes[kind].name);
    check_alive(L, index, a);
    return a;
}

static uint64_t check_place(lua_State *L, int index, const array *a)
{
    lua_Integer i = luaL_checkinteger(L, index);
    if (i < 0 || (uint64_t)i >= a->n)
        luaL_argerror(L, index,
                      lua_pushfstring(L, "place %I of %I rows, counted from 0", (LUAI_UACINT)i,
                                      (LUAI_UACINT)a->n));
    return (uint64_t)i;
}

static int push_row(lua_State *L, const array *a, uint64_t i)
{
    for (int column = 0; column < columns[a->kind]; ++column) {
        if (a->kind == ARRAY_PAIRS)
            lua_pushinteger(L, ((const uint32_t *)row_at(a, i))[column]);
        else
            lua_pushnumber(L, ((const float *)row_at(a, i))[column]);
    }
    return columns[a->kind];
}

static int array_get(lua_State *L)
{
    const array *a = check_self(L);
    return push_row(L, a, check_place(L, 2, a));
}

static int array_set(lua_State *L)
{
    const array *a = check_self(L);
    uint64_t i = check_place(L, 2, a);
    int width = columns[a->kind];
    luaL_argcheck(L, !a->fixed, 1, "the objects of a scene cannot be changed");
    if (lua_gettop(L) != width + 2)
        return luaL_error(L, "%s: row %I: %d numbers, and a row has %d", classes[a->kind].name,
                          (LUAI_UACINT)i, lua_gettop(L) - 2, width);
    for (int column = 0; column < width; ++column) {
        lua_pushvalue(L, 3 + column);
        take_column(L, a, i, column);
    }
    return 0;
}

// The next place and its row; upvalues: the array, the place.
static int next_row(lua_State *L)
{
    const array *a = lua_touserdata(L, lua_upvalueindex(1));
    lua_Integer i = lua_tointeger(L, lua_upvalueindex(2));
    check_alive(L, 1, a);
    if ((uint64_t)i >= a->n)
        return 0;
    lua_pushinteger(L, i + 1);
    lua_replace(L, lua_upvalueindex(2));
    lua_pushinteger(L, i);
    return 1 + push_row(L, a, (uint64_t)i);
}

static int array_each(lua_State *L)
{
    check_self(L);
    lua_pushvalue(L, 1);
    lua_pushinteger(L, 0);
    lua_pushcclosure(L, next_row, 2);
    return 1;
}

static int array_bytes(lua_State *L)
{
    const array *a = check_self(L);
    lua_pushlstring(L, a->rows ? a->rows : "", a->n * row_bytes(a));
    return 1;
}

static int array_length(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)check_self(L)->n);
    return 1;
}

void array_push_hash(lua_State *L, uint64_t hash)
{
    char digits[24];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    lua_pushstring(L, digits);
}

static int array_tostring(lua_State *L)
{
    const array *a = check_self(L);
    lua_pushfstring(L, "%s of %I rows", classes[a->kind].name, (LUAI_UACINT)a->n);
    return 1;
}

static int pairs_hash(lua_State *L)
{
    const array *a = array_check(L, 1, ARRAY_PAIRS);
    array_push_hash(L, duet_pairs_hash(a->rows, a->n));
    return 1;
}

static int poses_collide(lua_State *L)
{
    const array *a = array_check(L, 1, ARRAY_POSES);
    const duet_pose *first = row_at(a, check_place(L, 2, a));
    const duet_pose *second = row_at(a, check_place(L, 3, a));
    lua_Integer dims = luaL_optinteger(L, 4, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 4, "2 or 3 dimensions");
    lua_pushboolean(L, duet_poses_collide(first, second, (uint32_t)dims));
    return 1;
}

static int array_close(lua_State *L)
{
    array *a = test_array(L, 1);
    if (!a)
        return luaL_typeerror(L, 1, "duet.poses, duet.bounds or duet.pairs");
    if (a->owned)
        duet_free(a->rows);
    a->owned = false;
    if (a->n > 0)
        a->rows = NULL;
    return 0;
}

#define EVERY_KIND                                                                        \
    {"get", array_get}, {"set", array_set}, {"each", array_each}, {"bytes", array_bytes}, \
    {                                                                                     \
        "close", array_close                                                              \
    }

static const luaL_Reg poses_methods[] = {EVERY_KIND, {"collide", poses_collide}, {NULL, NULL}};
static const luaL_Reg bounds_methods[] = {EVERY_KIND, {NULL, NULL}};
static const luaL_Reg pairs_methods[] = {EVERY_KIND, {"hash", pairs_hash}, {NULL, NULL}};
static const luaL_Reg metas[] = {
    {"__len", array_length}, {"__tostring", array_tostring}, {NULL, NULL}};

static const lua_class classes[] = {
    [ARRAY_POSES] = {.name = "duet.poses", .methods = poses_methods, .metas = metas},
    [ARRAY_BOUNDS] = {.name = "duet.bounds", .methods = bounds_methods, .metas = metas},
    [ARRAY_PAIRS] = {.name = "duet.pairs", .methods = pairs_methods, .metas = metas},
};

void array_open(lua_State *L)
{
    static const luaL_Reg makers[] = {
        {"poses", make_poses}, {"bounds", make_bounds}, {"pairs", make_pairs}, {NULL, NULL}};
    for (int kind = 0; kind < 3; ++kind)
        class_open(L, &classes[kind]);
    luaL_setfuncs(L, makers, 0);
}
