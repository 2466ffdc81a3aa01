// SPDX-License-Identifier: MIT
// Stands in until gen.c lands (helper gen: delete this file then).
#include "gen/gen.h"
#include "runtime/base/blob.h"
#include "runtime/base/text.h"
#include <lauxlib.h>
#include <lualib.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
struct gen {
    lua_State *L;
    gen_param params[16];
    int64_t values[16][16];
    char names[16][32];
};
gen *gen_open(const char *dir, duet_error *err)
{
    (void)dir;
    (void)err;
    gen *g = calloc(1, sizeof *g);
    g->L = luaL_newstate();
    luaL_openlibs(g->L);
    return g;
}
void gen_close(gen *g)
{
    if (g)
        lua_close(g->L);
    free(g);
}
bool gen_params(gen *g, const char *kernel, const gen_limits *limits, const gen_param **params,
                uint32_t *n_params, duet_error *err)
{
    lua_State *L = g->L;
    char path[128];
    snprintf(path, sizeof path, "kernels/%s.lua", kernel);
    const blob *b = blob_find(path);
    if (!b)
        return error_set(err, DUET_NOT_FOUND, "%s", path);
    lua_settop(L, 0);
    if (luaL_loadbuffer(L, b->bytes, b->length, path) || lua_pcall(L, 0, 1, 0))
        return error_set(err, DUET_BUILD_FAILED, "%s", lua_tostring(L, -1));
    lua_getfield(L, 1, "params");
    int n = (int)luaL_len(L, 2);
    for (int i = 0; i < n; ++i) {
        lua_rawgeti(L, 2, i + 1);
        lua_rawgeti(L, 3, 1);
        snprintf(g->names[i], 32, "%s", lua_tostring(L, -1));
        lua_getfield(L, 3, "default");
        if (lua_isfunction(L, -1)) {
            lua_newtable(L);
            lua_pushboolean(L, limits->cpu);
            lua_setfield(L, -2, "cpu");
            lua_pushinteger(L, limits->max_group);
            lua_setfield(L, -2, "max_group");
            if (lua_pcall(L, 1, 1, 0))
                return error_set(err, DUET_BUILD_FAILED, "%s", lua_tostring(L, -1));
        }
        g->params[i] = (gen_param){.name = g->names[i], .fallback = lua_tointeger(L, -1)};
        lua_settop(L, 2);
    }
    *params = g->params;
    *n_params = (uint32_t)n;
    return true;
}
bool gen_make(gen *g, const char *kernel, const gen_setting *settings, uint32_t n_settings,
              const gen_limits *limits, gen_variant *v, duet_error *err)
{
    const gen_param *params;
    uint32_t n;
    if (!gen_params(g, kernel, limits, &params, &n, err))
        return false;
    text t = {0};
    lua_State *L = g->L;
    lua_settop(L, 1);
    lua_newtable(L);
    int at = snprintf(v->name, sizeof v->name, "%s", kernel);
    for (uint32_t i = 0; i < n; ++i) {
        int64_t value = params[i].fallback;
        for (uint32_t k = 0; k < n_settings; ++k)
            if (strcmp(settings[k].name, params[i].name) == 0)
                value = settings[k].value;
        text_add(&t, "#define %s %lld\n", params[i].name, (long long)value);
        lua_pushinteger(L, value);
        lua_setfield(L, 2, params[i].name);
        at += snprintf(v->name + at, sizeof v->name - (size_t)at, ".%s%lld", params[i].name, (long long)value);
    }
    text_add(&t, "%s", blob_find("kernels/common.clh")->bytes);
    lua_getfield(L, 1, "uses");
    int uses = lua_istable(L, -1) ? (int)luaL_len(L, -1) : 0;
    for (int i = 1; i <= uses; ++i) {
        char path[128];
        lua_rawgeti(L, 3, i);
        snprintf(path, sizeof path, "kernels/%s", lua_tostring(L, -1));
        text_add(&t, "%s", blob_find(path)->bytes);
        lua_pop(L, 1);
    }
    char path[128];
    snprintf(path, sizeof path, "kernels/%s.cl", kernel);
    text_add(&t, "#line 1 \"%s\"\n%s", path, blob_find(path)->bytes);
    lua_getfield(L, 1, "launch");
    lua_pushvalue(L, 2);
    if (lua_pcall(L, 1, 1, 0))
        return error_set(err, DUET_BUILD_FAILED, "%s", lua_tostring(L, -1));
    lua_getfield(L, -1, "group");
    v->group = (uint32_t)lua_tointeger(L, -1);
    lua_pop(L, 1);
    lua_getfield(L, -1, "per_item");
    v->per_item = (uint32_t)lua_tointeger(L, -1);
    v->text = t.chars;
    SHA256Data((const uint8_t *)t.chars, t.length, v->sha256);
    return true;
}
void gen_variant_free(gen_variant *v)
{
    free(v->text);
    *v = (gen_variant){0};
}
