// SPDX-License-Identifier: MIT
#include "runtime/scene/scene_ground.h"

#include "runtime/duet.h"

#include <lauxlib.h>
#include <string.h>

bool ground_has_only(lua_State *L, const char *const names[])
{
    bool known = true;
    for (lua_pushnil(L); known && lua_next(L, -2);) {
        bool found = false;
        for (size_t i = 0; names[i]; ++i)
            found = found ||
                    (lua_type(L, -2) == LUA_TSTRING && strcmp(lua_tostring(L, -2), names[i]) == 0);
        known = found;
        lua_pop(L, known ? 1 : 2);
    }
    return known;
}

bool ground_read_numbers(lua_State *L, const char *name, double *to, int n)
{
    int type = lua_getfield(L, -1, name);
    for (int k = 0; k < n && type == LUA_TNUMBER; ++k)
        to[k] = lua_tonumber(L, -1);
    bool ok = type == LUA_TNUMBER || type == LUA_TNIL ||
              (type == LUA_TTABLE && lua_rawlen(L, -1) == (lua_Unsigned)n);
    for (int k = 0; k < n && ok && type == LUA_TTABLE; ++k) {
        ok = lua_rawgeti(L, -1, k + 1) == LUA_TNUMBER;
        to[k] = lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return ok;
}

bool ground_read_origin(lua_State *L, double to[3])
{
    bool is_list = lua_getfield(L, -1, "origin") != LUA_TNUMBER;
    lua_pop(L, 1);
    return is_list && ground_read_numbers(L, "origin", to, 3);
}

bool ground_read_material(lua_State *L, uint32_t *to)
{
    bool is_left_out = lua_getfield(L, -1, "material") == LUA_TNIL;
    lua_Integer n = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
    lua_pop(L, 1);
    *to = is_left_out ? 0 : (uint32_t)n;
    return is_left_out || (n >= 1 && n < DUET_MATERIALS);
}

bool ground_read_carrier(lua_State *L, uint32_t *to)
{
    bool is_left_out = lua_getfield(L, -1, "carrier") == LUA_TNIL;
    lua_Integer id = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : -1;
    lua_pop(L, 1);
    *to = is_left_out ? 0 : (uint32_t)(id + 1);
    return is_left_out || (id >= 0 && id < UINT32_MAX);
}
