// SPDX-License-Identifier: MIT
// A ground of heights as a Lua table:
// { nx = 65, ny = 65, spacing = 1, origin = { 0, 0, 0 }, values = { ... }, material = 1 }
#include "runtime/scene/scene_heights.h"

#include "runtime/scene/scene_ground.h"

#include <math.h>

#define SIDE "a whole number from 2 on, nx times ny 2^26 at most"

static const field heights_fields[] = {
    FIELD_WITHIN(duet_heights, , nx, 2, DUET_MOST_HEIGHTS, SIDE),
    FIELD_WITHIN(duet_heights, , ny, 2, DUET_MOST_HEIGHTS, SIDE),
    FIELD(field_spacing, duet_heights, spacing),
    GROUND_FIELDS(duet_heights),
    {.name = "values", .type = &field_unread},
    {0},
};

// As they stand in the table: its metatable is not asked. Returns their type.
static int push_values(lua_State *L)
{
    lua_pushliteral(L, "values");
    return lua_rawget(L, -2);
}

void heights_read_values(lua_State *L, const duet_heights *h, float *to)
{
    bool ok = true;
    push_values(L);
    for (uint32_t i = 0; ok && i < h->nx * h->ny; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        to[i] = (float)lua_tonumber(L, -1);
        ok = ok && isfinite(to[i]);
        lua_pop(L, 1);
    }
    if (!ok)
        field_raise(L, "values", "heights: values must be finite numbers");
    lua_pop(L, 1);
}

void heights_read(lua_State *L, duet_heights *h)
{
    *h = (duet_heights){.spacing = {1, 1}};
    field_read_row(L, -1, (field_table){"heights", -1, NULL}, heights_fields, h);
    uint64_t n = (uint64_t)h->nx * h->ny;
    if (n == 0 || n > DUET_MOST_HEIGHTS)
        field_raise(L, "heights", "heights: nx is %u, ny is %u; expected " SIDE, h->nx, h->ny);
    if (push_values(L) != LUA_TTABLE || lua_rawlen(L, -1) != n)
        field_raise(L, "values", "heights: values must be nx times ny numbers, row by row along x");
    lua_pop(L, 1);
}
