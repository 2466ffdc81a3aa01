// SPDX-License-Identifier: MIT
// The joint strategy that is a function of a script.
#include "tuner/joint_strategy.h"
#include "tuner/strategy.h"

#include <lauxlib.h>

static void set_number(lua_State *L, const char *name, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

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
    lua_Integer n = 0;
    lua_newtable(L);
    for (int device = 0; device < 2; ++device)
        for (uint32_t i = 0; i < s->n_kernels[device]; ++i) {
            const kernel_space *k = &s->kernels[device][i];
            lua_newtable(L);
            lua_pushstring(L, device == 0 ? "A" : "B");
            lua_setfield(L, -2, "device");
            lua_pushstring(L, k->kernel);
            lua_setfield(L, -2, "name");
            lua_pushinteger(L, (lua_Integer)k->now + 1);
            lua_setfield(L, -2, "now");
            push_configs(L, k);
            lua_setfield(L, -2, "configs");
            lua_rawseti(L, -2, ++n);
        }
}

static void push_space(lua_State *L, const joint_history *h)
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
    lua_pushinteger(L, (lua_Integer)h->most);
    lua_setfield(L, -2, "most");
}

static void push_sample(lua_State *L, const joint_space *s, const joint_sample *at)
{
    lua_Integer n = 0;
    lua_createtable(L, 0, 6);
    set_number(L, "share", at->at.share / (double)SEARCH_ONE);
    set_number(L, "total", (double)at->times.total_ns * 1e-6);
    set_number(L, "a", (double)at->times.a_ns * 1e-6);
    set_number(L, "b", (double)at->times.b_ns * 1e-6);
    lua_pushboolean(L, at->usable);
    lua_setfield(L, -2, "ok");
    lua_newtable(L);
    for (int device = 0; device < 2; ++device)
        for (uint32_t i = 0; i < s->n_kernels[device]; ++i) {
            lua_pushinteger(L, (lua_Integer)at->at.configs[device][i] + 1);
            lua_rawseti(L, -2, ++n);
        }
    lua_setfield(L, -2, "configs");
}

static void push_history(lua_State *L, const joint_history *h)
{
    lua_createtable(L, (int)h->n, 0);
    for (uint32_t i = 0; i < h->n; ++i) {
        push_sample(L, h->space, &h->samples[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

// The point at the top of the stack, which is the script's own and may be anything.
static joint_point read_point(lua_State *L, const joint_space *s)
{
    joint_point p = joint_space_base(s, 0);
    lua_Integer n = 0;
    if (!lua_istable(L, -1))
        luaL_error(L, "the strategy gave a %s; expected { share =, configs = } or nil",
                   luaL_typename(L, -1));
    lua_getfield(L, -1, "share");
    double share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        luaL_error(L, "the strategy's share is %s; expected 0 to 1", script_tostring(L, -1, NULL));
    p.share = s->points ? (uint32_t)(share * SEARCH_ONE + 0.5) : 0;
    lua_getfield(L, -2, "configs");
    for (int device = 0; device < 2 && lua_istable(L, -1); ++device)
        for (uint32_t i = 0; i < s->n_kernels[device]; ++i) {
            lua_geti(L, -1, ++n);
            lua_Integer config = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
            if (config < 1 || config > (lua_Integer)s->kernels[device][i].n_configs)
                luaL_error(L, "config %d is %s; expected 1 to %d", (int)n,
                           script_tostring(L, -1, NULL), (int)s->kernels[device][i].n_configs);
            p.configs[device][i] = (uint16_t)(config - 1);
            lua_pop(L, 1);
        }
    return p;
}

// function, history, next ->
static int call_function(lua_State *L)
{
    const joint_history *h = lua_touserdata(L, 2);
    joint_next *next = lua_touserdata(L, 3);
    lua_pushvalue(L, 1);
    push_space(L, h);
    push_history(L, h);
    lua_call(L, 2, 1);
    next->done = lua_isnil(L, -1);
    if (!next->done)
        next->at = read_point(L, h->space);
    joint_space_normalize(h->space, &next->at);
    return 0;
}

static bool ask_lua(const joint_history *h, joint_next *next, duet_error *err)
{
    *next = (joint_next){.done = true};
    return strategy_lua_call(h->script, call_function, h, next, err);
}

const joint_strategy joint_strategy_lua = {
    .name = "lua",
    .about = "a function of a script: space and history in, next plan or nil out",
    .ask = ask_lua,
};
