// SPDX-License-Identifier: MIT
#include "runtime/scene/scene_ground.h"

// Reads a list of exactly n numbers.
static void read_numbers(lua_State *L, const field *f, double *to, lua_Unsigned n,
                         const char *expected)
{
    bool ok = lua_istable(L, -1) && lua_rawlen(L, -1) == n;
    for (lua_Unsigned k = 0; ok && k < n; ++k) {
        ok = lua_rawgeti(L, -1, (lua_Integer)k + 1) == LUA_TNUMBER;
        to[k] = lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
    if (!ok)
        field_refuse(L, f, expected);
}

static void read_spacing(lua_State *L, const field *f, void *at)
{
    double *spacing = at;
    if (lua_type(L, -1) == LUA_TNUMBER)
        spacing[0] = spacing[1] = lua_tonumber(L, -1);
    else
        read_numbers(L, f, spacing, 2, "a number, or two");
}

static void read_origin(lua_State *L, const field *f, void *at)
{
    read_numbers(L, f, at, 3, "three numbers");
}

static void read_carrier(lua_State *L, const field *f, void *at)
{
    lua_Integer id = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : -1;
    if (id < 0 || id >= UINT32_MAX)
        field_refuse(L, f, "the id of a body");
    *(uint32_t *)at = (uint32_t)(id + 1);
}

const field_type field_spacing = {.read = read_spacing};
const field_type field_origin = {.read = read_origin};
const field_type field_carrier = {.read = read_carrier};
