// SPDX-License-Identifier: MIT
// A ground of heights as a Lua table:
// { nx = 65, ny = 65, spacing = 1, origin = { 0, 0, 0 }, values = { ... }, material = 1 }
#include "runtime/scene/scene_heights.h"

#include "runtime/scene/scene_ground.h"

#include <lauxlib.h>
#include <math.h>

static bool read_count(lua_State *L, const char *name, uint32_t *to)
{
    lua_getfield(L, -1, name);
    lua_Integer n = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
    lua_pop(L, 1);
    *to = (uint32_t)n;
    return n >= 2 && n <= DUET_MOST_HEIGHTS;
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
    static const char *const names[] = {"nx",     "ny",       "spacing", "origin",
                                        "values", "material", NULL};
    *h = (duet_heights){.spacing = {1, 1}};
    if (!ground_has_only(L, names))
        return "the fields are nx, ny, spacing, origin, values and material";
    if (!read_count(L, "nx", &h->nx) || !read_count(L, "ny", &h->ny) ||
        (uint64_t)h->nx * h->ny > DUET_MOST_HEIGHTS)
        return "nx and ny must be whole numbers from 2 on, their product 2^26 at most";
    if (!ground_read_numbers(L, "spacing", h->spacing, 2))
        return "spacing must be a number, or two";
    if (!ground_read_origin(L, h->origin))
        return "origin must be three numbers";
    if (!ground_read_material(L, &h->material))
        return "material must be the number of one of the materials";
    return has_all_values(L, h) ? NULL : "values must be nx times ny numbers, row by row along x";
}
