// SPDX-License-Identifier: MIT
#include "tuner/strategy_lua.h"

#include "tuner/strategy.h"

#include <lauxlib.h>
#include <string.h>

// The script's function stays at the bottom of its stack.
enum { FUNCTION = 1 };

// what the script returned -> the function in it
static int find_function(lua_State *L)
{
    if (lua_istable(L, 1))
        lua_getfield(L, 1, "strategy");
    return 1;
}

script *strategy_lua_open(const char *name, const char *chars, duet_error *err)
{
    script *s = script_open(NULL, err);
    if (!s)
        return NULL;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, find_function);
    bool ok = script_run(s, name, chars, strlen(chars), 1, err) && script_call(s, 1, 1, err);
    if (ok && !lua_isfunction(L, FUNCTION))
        ok = error_set(err, DUET_STATUS_BAD_INPUT,
                       "%s: the strategy is a %s; expected a function of the history", name,
                       luaL_typename(L, FUNCTION));
    if (!ok) {
        script_close(s);
        return NULL;
    }
    return s;
}

static void set_number(lua_State *L, const char *name, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

static void push_history(lua_State *L, const search *s)
{
    lua_createtable(L, (int)s->n, 0);
    for (uint32_t i = 0; i < s->n; ++i) {
        const search_sample *at = &s->samples[i];
        lua_createtable(L, 0, 4);
        set_number(L, "share", at->share / (double)SEARCH_ONE);
        set_number(L, "total", (double)at->total_ns * 1e-6);
        set_number(L, "a", (double)at->a_ns * 1e-6);
        set_number(L, "b", (double)at->b_ns * 1e-6);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

// function, search, next ->
static int call_function(lua_State *L)
{
    const search *s = lua_touserdata(L, 2);
    search_next *next = lua_touserdata(L, 3);
    lua_pushvalue(L, 1);
    push_history(L, s);
    lua_call(L, 1, 1);
    next->done = lua_isnil(L, -1);
    if (next->done)
        return 0;
    double share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        return luaL_error(L, "the strategy gave %s; expected a share of 0 to 1, or nil",
                          script_tostring(L, -1, NULL));
    next->share = (uint32_t)(share * SEARCH_ONE + 0.5);
    return 0;
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    if (!s->script)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "strategy 'lua': there is no script; expected a function in tune.lua");
    lua_State *L = script_lua(s->script);
    lua_pushcfunction(L, call_function);
    lua_pushvalue(L, FUNCTION);
    lua_pushlightuserdata(L, (void *)s);
    lua_pushlightuserdata(L, next);
    return script_call(s->script, 3, 0, err);
}

const strategy strategy_lua = {
    .name = "lua",
    .about = "a function of a script: history in, next share or nil out",
    .launches = 64,
    .ask = ask,
    .pick = strategy_pick_fastest,
};
