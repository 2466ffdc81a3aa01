// SPDX-License-Identifier: MIT
// The strategies that are a function of a script.
#include "gen/sandbox.h"
#include "tuner/joint_space.h"
#include "tuner/strategy.h"

#include <lauxlib.h>
#include <string.h>

// The script's function stays at the bottom of its stack, and above it whether it chooses kernels
// too.
enum { FUNCTION = 1, IS_JOINT = 2 };

// the script's result -> the function in it, whether it is the field `joint`
static int find_function(lua_State *L)
{
    bool is_table = lua_istable(L, 1);
    bool joint = is_table && lua_getfield(L, 1, "joint") != LUA_TNIL;
    if (is_table && !joint)
        lua_getfield(L, 1, "strategy");
    lua_pushboolean(L, joint);
    return 2;
}

script *strategy_lua_open(const char *name, const char *chars, duet_error *err)
{
    script *s = sandbox_open(NULL, err);
    if (!s)
        return NULL;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, find_function);
    bool ok = script_run(s, name, chars, strlen(chars), 1, err) && script_call(s, 1, 2, err);
    if (ok && !lua_isfunction(L, FUNCTION))
        ok = bad_input(err, "%s: the strategy is a %s; expected a function of the history", name,
                       luaL_typename(L, FUNCTION));
    if (!ok) {
        script_close(s);
        return NULL;
    }
    return s;
}

bool strategy_lua_is_joint(script *s)
{
    return lua_toboolean(script_lua(s), IS_JOINT);
}

// ---------------------------------------------------------------- history

static void set_number(lua_State *L, const char *name, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

static void set_configs(lua_State *L, const joint_space *s, const search_sample *at)
{
    lua_createtable(L, (int)s->kernels.n, 0);
    for (uint32_t i = 0; i < s->kernels.n; ++i) {
        lua_pushinteger(L, (lua_Integer)at->configs[i] + 1);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "configs");
    lua_pushboolean(L, !at->failed);
    lua_setfield(L, -2, "ok");
}

static void push_history(lua_State *L, const search *h, bool joint)
{
    lua_createtable(L, (int)h->n, 0);
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        lua_createtable(L, 0, 6);
        set_number(L, "share", at->share / (double)SEARCH_ONE);
        set_number(L, "total", (double)at->total_ns * 1e-6);
        set_number(L, "a", (double)at->a_ns * 1e-6);
        set_number(L, "b", (double)at->b_ns * 1e-6);
        if (joint)
            set_configs(L, h->space, at);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

// ---------------------------------------------------------------- space

// { { WG = 16, ... }, ... }
static void push_configs(lua_State *L, const kernel_space *k)
{
    lua_createtable(L, (int)k->n_configs, 0);
    for (uint32_t i = 0; i < k->n_configs; ++i) {
        lua_createtable(L, 0, (int)k->n_params);
        for (uint32_t p = 0; p < k->n_params; ++p) {
            lua_pushinteger(L, k->params[p].values[k->configs[i][p]]);
            lua_setfield(L, -2, k->params[p].name);
        }
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

static void push_kernels(lua_State *L, const joint_space *s)
{
    lua_createtable(L, (int)s->kernels.n, 0);
    for (uint32_t i = 0; i < s->kernels.n; ++i) {
        const kernel_space *k = &s->kernels.of[i];
        lua_newtable(L);
        lua_pushstring(L, i < s->n_a ? "A" : "B");
        lua_setfield(L, -2, "device");
        lua_pushstring(L, k->kernel);
        lua_setfield(L, -2, "name");
        lua_pushinteger(L, (lua_Integer)k->now + 1);
        lua_setfield(L, -2, "now");
        push_configs(L, k);
        lua_setfield(L, -2, "configs");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

static void push_space(lua_State *L, const search *h)
{
    lua_newtable(L);
    push_kernels(L, h->space);
    lua_setfield(L, -2, "kernels");
    lua_newtable(L);
    for (uint32_t i = 0; i <= h->space->points; ++i) {
        lua_pushnumber(L, h->space->points ? i / (double)h->space->points : 0);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "shares");
    lua_pushinteger(L, (lua_Integer)h->seed);
    lua_setfield(L, -2, "seed");
    lua_pushinteger(L, (lua_Integer)h->options.launches);
    lua_setfield(L, -2, "most");
}

// ---------------------------------------------------------------- plans

// The share at the top of the stack, which is the script's own and may be anything.
static uint32_t read_share(lua_State *L, const char *complaint)
{
    double share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        luaL_error(L, complaint, script_tostring(L, -1, NULL));
    return (uint32_t)(share * SEARCH_ONE + 0.5);
}

// The plan at the top of the stack.
static search_sample read_point(lua_State *L, const joint_space *s)
{
    search_sample p = joint_space_base(s, 0);
    if (!lua_istable(L, -1))
        luaL_error(L, "the strategy gave a %s; expected { share =, configs = } or nil",
                   luaL_typename(L, -1));
    lua_getfield(L, -1, "share");
    uint32_t share = read_share(L, "the strategy's share is %s; expected 0 to 1");
    p.share = s->points ? share : 0;
    lua_getfield(L, -2, "configs");
    for (uint32_t i = 0; lua_istable(L, -1) && i < s->kernels.n; ++i) {
        lua_geti(L, -1, (lua_Integer)i + 1);
        lua_Integer config = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
        if (config < 1 || config > (lua_Integer)s->kernels.of[i].n_configs)
            luaL_error(L, "config %d is %s; expected 1 to %d", (int)i + 1,
                       script_tostring(L, -1, NULL), (int)s->kernels.of[i].n_configs);
        p.configs[i] = (uint16_t)(config - 1);
        lua_pop(L, 1);
    }
    joint_space_normalize(s, &p);
    return p;
}

// ---------------------------------------------------------------- calls

// function, whether it chooses kernels too, search, next ->
static int call_function(lua_State *L)
{
    const search *h = lua_touserdata(L, 3);
    const bool joint = lua_toboolean(L, IS_JOINT) && h->space;
    search_next *next = lua_touserdata(L, 4);
    lua_pushvalue(L, FUNCTION);
    if (joint)
        push_space(L, h);
    push_history(L, h, joint);
    lua_call(L, joint ? 2 : 1, 1);
    next->done = lua_isnil(L, -1);
    if (next->done)
        return 0;
    if (joint)
        next->at = read_point(L, h->space);
    else
        next->at.share = read_share(L, "the strategy gave %s; expected a share of 0 to 1, or nil");
    return 0;
}

static bool ask(const search *h, search_next *next, duet_error *err)
{
    if (!h->script)
        return bad_argument(err,
                            "strategy 'lua': there is no script; expected a function in tune.lua");
    lua_State *L = script_lua(h->script);
    lua_pushcfunction(L, call_function);
    lua_pushvalue(L, FUNCTION);
    lua_pushvalue(L, IS_JOINT);
    lua_pushlightuserdata(L, (void *)h);
    lua_pushlightuserdata(L, next);
    return script_call(h->script, 4, 0, err);
}

const strategy strategy_lua = {
    .name = "lua",
    .about = "a function of a script: history in, next share or nil out",
    .launches = 64,
    .ask = ask,
    .pick = search_fastest,
};

const strategy strategy_lua_joint = {
    .name = "lua",
    .about = "a function of a script: space and history in, next plan or nil out",
    .choice = STRATEGY_JOINT,
    .ask = ask,
};
