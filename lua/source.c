// SPDX-License-Identifier: MIT
// duet.source: the exact text of a kernel, and what it lets vary.
#include "lua/nouns.h"

#include "gen/gen.h"

enum { MOST_SETTINGS = 64 };

// The generator and a variant of it, to be collected where an error is raised.
typedef struct source_box {
    gen *gen;
    gen_variant variant;
} source_box;

static int generator_close(lua_State *L)
{
    source_box *box = luaL_checkudata(L, 1, "duet.generator");
    gen_variant_free(&box->variant);
    gen_close(box->gen);
    *box = (source_box){0};
    return 0;
}

static const lua_class source_class = {
    .name = "duet.generator",
};

static source_box *push_generator(lua_State *L, duet_error *err)
{
    source_box *box = class_push(L, &source_class, sizeof *box);
    box->gen = gen_open(duet_default_device_pair_def().kernel_dir, err);
    return box->gen ? box : NULL;
}

// ---------------------------------------------------------------- limits

// The least that OpenCL 1.2 asks for and GPUs have, or what the table says.
static gen_limits read_limits(lua_State *L, int index)
{
    gen_limits limits = {.max_group = 256, .local_bytes = 32 << 10, .fp64 = true};
    field_read(L, index, "a device's limits",
               FIELD_LIST(gen_limits, max_group, local_bytes, fp64, cpu, units), &limits);
    return limits;
}

// { WG = 64 } -> settings, whose names the table keeps alive
static uint32_t read_settings(lua_State *L, int index, gen_setting settings[MOST_SETTINGS])
{
    uint32_t n = 0;
    if (lua_isnoneornil(L, index))
        return 0;
    luaL_checktype(L, index, LUA_TTABLE);
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        int is_whole = 0;
        lua_Integer value = lua_tointegerx(L, -1, &is_whole);
        if (!field_text(L, -2) || !is_whole || n == MOST_SETTINGS)
            luaL_error(L, "a kernel's settings are at most %d names with whole numbers",
                       MOST_SETTINGS);
        settings[n++] = (gen_setting){lua_tostring(L, -2), value};
    }
    return n;
}

// ---------------------------------------------------------------- functions

static const field variant_fields[] = {
    FIELDS(gen_variant, name, sha256),
    FIELD(field_string, gen_variant, text),
    FIELDS(gen_variant, group, per_item),
    {0},
};

// duet.source(kernel, settings, limits)
static int make_source(lua_State *L)
{
    duet_error err = {0};
    gen_setting settings[MOST_SETTINGS];
    const char *kernel = text_check(L, 1);
    lua_settop(L, 3);
    uint32_t n = read_settings(L, 2, settings);
    gen_limits limits = read_limits(L, 3);
    source_box *box = push_generator(L, &err);
    if (!box || !gen_make(box->gen, kernel, settings, n, &limits, &box->variant, &err))
        return class_push_failure(L, &err);
    field_push_table(L, variant_fields, &box->variant);
    return 1;
}

static void push_param(lua_State *L, const gen_param *param)
{
    lua_newtable(L);
    lua_pushstring(L, param->name);
    lua_setfield(L, -2, "name");
    lua_pushstring(L, param->about);
    lua_setfield(L, -2, "about");
    lua_pushinteger(L, param->fallback);
    lua_setfield(L, -2, "default");
    lua_newtable(L);
    for (uint32_t i = 0; i < param->n_values; ++i) {
        lua_pushinteger(L, param->values[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "values");
}

static bool push_kernel(lua_State *L, gen *g, const char *name, const gen_limits *limits,
                        duet_error *err)
{
    const char *about = NULL;
    const gen_param *params = NULL;
    uint32_t n = 0;
    uint64_t configs = 0;
    if (!gen_about(g, name, &about, err) || !gen_count(g, name, limits, &configs, err))
        return false;
    lua_newtable(L);
    lua_pushstring(L, name);
    lua_setfield(L, -2, "name");
    lua_pushstring(L, about);
    lua_setfield(L, -2, "about");
    lua_pushinteger(L, (lua_Integer)configs);
    lua_setfield(L, -2, "configs");
    if (!gen_params(g, name, limits, &params, &n, err))
        return false;
    lua_newtable(L);
    for (uint32_t i = 0; i < n; ++i) {
        push_param(L, &params[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "params");
    return true;
}

// duet.kernels(limits): one table a kernel
static int list_kernels(lua_State *L)
{
    duet_error err = {0};
    gen_limits limits = read_limits(L, 1);
    source_box *box = push_generator(L, &err);
    if (!box)
        return class_push_failure(L, &err);
    lua_newtable(L);
    for (uint32_t i = 0; gen_kernel(box->gen, i); ++i) {
        if (!push_kernel(L, box->gen, gen_kernel(box->gen, i), &limits, &err))
            return class_push_failure(L, &err);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

const lua_noun source_noun = {{&source_class},
                              (const lua_method[]){{"duet.source", make_source, 0},
                                                   {"duet.kernels", list_kernels, 0},
                                                   METHODS(generator, close),
                                                   {0}}};
