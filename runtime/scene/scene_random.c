// SPDX-License-Identifier: MIT
// Random numbers for scenes: rng.h's, so that a scene is the same on every machine. They draw from
// a source that the script seeds; two sources are independent of each other.
#include "runtime/scene/scene_lua.h"

#include "base/rng.h"

#include <lauxlib.h>
#include <math.h>

#define TURN 6.283185307179586476925

static rng *source_of(lua_State *L)
{
    return lua_touserdata(L, lua_upvalueindex(1));
}

// uniform(from, to): from 0 to 1 where they are left out
static int draw_uniform(lua_State *L)
{
    double from = luaL_optnumber(L, 1, 0);
    double to = luaL_optnumber(L, 2, 1);
    lua_pushnumber(L, rng_between(source_of(L), from, to));
    return 1;
}

// integer(from, to): both may be drawn
static int draw_integer(lua_State *L)
{
    lua_Integer from = luaL_checkinteger(L, 1);
    lua_Integer to = luaL_checkinteger(L, 2);
    luaL_argcheck(L, from <= to, 2, "must not be below the first");
    lua_Unsigned span = (lua_Unsigned)to - (lua_Unsigned)from;
    luaL_argcheck(L, span < UINT32_MAX, 2, "must be less than 2^32-1 above the first");
    lua_pushinteger(L, from + (lua_Integer)rng_below(source_of(L), (uint32_t)span + 1));
    return 1;
}

// normal(mean, deviation): 0 and 1 where they are left out
static int draw_normal(lua_State *L)
{
    double mean = luaL_optnumber(L, 1, 0);
    double deviation = luaL_optnumber(L, 2, 1);
    lua_pushnumber(L, mean + deviation * rng_normal(source_of(L)));
    return 1;
}

// angle(): radians, a whole turn
static int draw_angle(lua_State *L)
{
    lua_pushnumber(L, rng_between(source_of(L), 0, TURN));
    return 1;
}

// A point in the unit disk, which is not its centre; returns its distance from
// there, squared.
static double draw_in_disk(rng *source, double point[2])
{
    for (;;) {
        point[0] = rng_between(source, -1, 1);
        point[1] = rng_between(source, -1, 1);
        double squared = point[0] * point[0] + point[1] * point[1];
        if (squared > 0 && squared < 1)
            return squared;
    }
}

// quaternion() -> x, y, z, w: all rotations are equally likely (Marsaglia
// 1972). It takes no sine, which would be another one on another machine.
static int draw_quaternion(lua_State *L)
{
    double a[2];
    double b[2];
    double a_squared = draw_in_disk(source_of(L), a);
    double scale = sqrt((1 - a_squared) / draw_in_disk(source_of(L), b));
    lua_pushnumber(L, a[0]);
    lua_pushnumber(L, a[1]);
    lua_pushnumber(L, b[0] * scale);
    lua_pushnumber(L, b[1] * scale);
    return 4;
}

// Pushes a table of functions that draw from one source, which is returned.
static rng *push_random(lua_State *L)
{
    static const luaL_Reg draws[] = {
        {"uniform", draw_uniform}, {"integer", draw_integer},       {"normal", draw_normal},
        {"angle", draw_angle},     {"quaternion", draw_quaternion}, {NULL, NULL},
    };
    luaL_newlibtable(L, draws);
    rng *source = lua_newuserdatauv(L, sizeof *source, 0);
    *source = rng_seed(0);
    luaL_setfuncs(L, draws, 1);
    return source;
}

int scene_word_random(lua_State *L)
{
    uint64_t seed = (uint64_t)luaL_checkinteger(L, 1);
    *push_random(L) = rng_seed(seed);
    return 1;
}

// ---------------------------------------------------------------- each
// Objects that do not know of each other: whoever wants a range of a scene makes
// no more than that.

// Calls the function at 2 with i and the table of draws at 3.
static void make_one(lua_State *L, const duet_scene *scene, lua_Integer i)
{
    uint64_t before = scene->n_read;
    lua_pushvalue(L, 2);
    lua_pushinteger(L, i);
    lua_pushvalue(L, 3);
    lua_call(L, 2, 0);
    if (scene->n_read != before + 1)
        luaL_error(L, "each: %I objects were added for i = %I; expected 1",
                   (LUAI_UACINT)(scene->n_read - before), (LUAI_UACINT)i);
}

int scene_word_each(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, lua_upvalueindex(1));
    duet_scene *scene = reading->scene;
    lua_Integer n = luaL_checkinteger(L, 1);
    luaL_argcheck(L, n >= 0 && n < (lua_Integer)1 << 62, 1, "expected 0 or more, below 2^62");
    luaL_checktype(L, 2, LUA_TFUNCTION);
    if (reading->in_each)
        return luaL_error(L, "each: called by the function of another each");
    lua_settop(L, 2);
    rng *source = push_random(L);
    uint64_t seed = rng_stream(reading->seed, reading->n_each++).state;
    reading->in_each = true;
    for (lua_Integer i = 1; i <= n; ++i) {
        // The first tells what kind of objects they are, kept or not.
        if (scene->columns != 0)
            i += (lua_Integer)scene_pass_over(scene, (uint64_t)(n - i + 1));
        if (i > n)
            break;
        if (scene->defers && i > 1) {
            scene->n_read += (uint64_t)(n - i + 1);
            scene->n_deferred += (uint64_t)(n - i + 1);
            break;
        }
        *source = rng_stream(seed, (uint64_t)i);
        make_one(L, scene, i);
    }
    reading->in_each = false;
    return 0;
}
