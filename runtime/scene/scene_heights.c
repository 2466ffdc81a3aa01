// SPDX-License-Identifier: MIT
// A ground of heights as a Lua table:
// { nx = 65, ny = 65, spacing = 1, origin = { 0, 0, 0 }, values = { ... }, material = 1 }
#include "runtime/scene/scene_heights.h"

#include <lauxlib.h>
#include <math.h>
#include <string.h>

// Up to three numbers in a list, or one for all of them; false for anything else.
static bool read_numbers(lua_State *L, const char *name, double *to, int n)
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

static bool read_count(lua_State *L, const char *name, uint32_t *to)
{
    lua_getfield(L, -1, name);
    lua_Integer n = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
    lua_pop(L, 1);
    *to = (uint32_t)n;
    return n >= 2 && n <= DUET_MOST_HEIGHTS;
}

// 0: there is none.
static bool read_material(lua_State *L, uint32_t *to)
{
    bool is_left_out = lua_getfield(L, -1, "material") == LUA_TNIL;
    lua_Integer n = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
    lua_pop(L, 1);
    *to = is_left_out ? 0 : (uint32_t)n;
    return is_left_out || (n >= 1 && n < DUET_MATERIALS);
}

static bool has_only_known(lua_State *L)
{
    static const char *const names[] = {"nx", "ny", "spacing", "origin", "values", "material"};
    bool known = true;
    for (lua_pushnil(L); known && lua_next(L, -2);) {
        bool found = false;
        for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
            found = found ||
                    (lua_type(L, -2) == LUA_TSTRING && strcmp(lua_tostring(L, -2), names[i]) == 0);
        known = found;
        lua_pop(L, known ? 1 : 2);
    }
    return known;
}

// Whether the list has nx times ny values, which are not read yet.
static bool has_all_values(lua_State *L, const duet_heights *h)
{
    bool has = lua_getfield(L, -1, "values") == LUA_TTABLE &&
               lua_rawlen(L, -1) == (lua_Unsigned)h->nx * h->ny;
    lua_pop(L, 1);
    return has;
}

const char *heights_read_values(lua_State *L, const duet_heights *h, float *to)
{
    bool ok = true;
    lua_getfield(L, -1, "values");
    for (uint32_t i = 0; ok && i < h->nx * h->ny; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        to[i] = (float)lua_tonumber(L, -1);
        ok = ok && isfinite(to[i]);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return ok ? NULL : "values must be finite numbers";
}

const char *heights_read(lua_State *L, duet_heights *h)
{
    *h = (duet_heights){.spacing = {1, 1}};
    if (!has_only_known(L))
        return "the fields are nx, ny, spacing, origin, values and material";
    if (!read_count(L, "nx", &h->nx) || !read_count(L, "ny", &h->ny) ||
        (uint64_t)h->nx * h->ny > DUET_MOST_HEIGHTS)
        return "nx and ny must be whole numbers from 2 on, their product 2^26 at most";
    if (!read_numbers(L, "spacing", h->spacing, 2))
        return "spacing must be a number, or two";
    lua_getfield(L, -1, "origin");
    bool is_list = !lua_isnumber(L, -1);
    lua_pop(L, 1);
    if (!is_list || !read_numbers(L, "origin", h->origin, 3))
        return "origin must be three numbers";
    if (!read_material(L, &h->material))
        return "material must be the number of one of the materials";
    return has_all_values(L, h) ? NULL : "values must be nx times ny numbers, row by row along x";
}
