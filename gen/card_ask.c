// SPDX-License-Identifier: MIT
// Asks the functions of a card. A config reaches them as a table with a field for each parameter.
#include "gen/card.h"
#include "gen/field.h"
#include "gen/sandbox.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The argument of a C function in the state, and its result.
typedef struct question {
    card *card;
    const gen_limits *limits;
    const gen_setting *config;
    gen_entry *entries;
    card_launch launch;
    bool is_valid;
    char reason[200];
} question;

// Objects that a CPU's work-item takes: fewer where there are many units, so that each has several.
static int batch_for(uint32_t units)
{
    enum { FEW_UNITS = 4 };
    return units > FEW_UNITS ? 256 : 1024;
}

static void push_limits(lua_State *L, const gen_limits *limits)
{
    lua_createtable(L, 0, 5);
    lua_pushinteger(L, limits->max_group);
    lua_setfield(L, -2, "max_group");
    lua_pushinteger(L, limits->local_bytes > INT64_MAX ? INT64_MAX : (int64_t)limits->local_bytes);
    lua_setfield(L, -2, "local_bytes");
    lua_pushboolean(L, limits->fp64);
    lua_setfield(L, -2, "fp64");
    lua_pushboolean(L, limits->cpu);
    lua_setfield(L, -2, "cpu");
    lua_pushinteger(L, batch_for(limits->units));
    lua_setfield(L, -2, "batch");
}

// valid(p, limits), where the card has it. The table is at [2].
static void ask_valid(lua_State *L, question *q)
{
    q->is_valid = true;
    if (lua_getfield(L, 2, "valid") == LUA_TFUNCTION) {
        signature_push_config(L, q->config, q->card->n_params);
        push_limits(L, q->limits);
        lua_call(L, 2, 2);
        q->is_valid = lua_isnil(L, -2) || lua_toboolean(L, -2);
        const char *reason = lua_tostring(L, -1);
        snprintf(q->reason, sizeof q->reason, "%s", reason ? reason : "its card says so");
    }
    lua_settop(L, 2);
}

// A number, which is on top, and pops it.
static uint32_t launch_number(lua_State *L, const char *name)
{
    int whole = 0;
    lua_Integer value = lua_tointegerx(L, -1, &whole);
    if (!whole || value < 1 || value > INT32_MAX)
        luaL_error(L, "launch gives no %s of 1 or more", name);
    lua_pop(L, 1);
    return (uint32_t)value;
}

// A number for the first axis, or a list with one for each; returns how many axes.
static uint32_t launch_field(lua_State *L, const char *name, uint32_t values[3])
{
    values[0] = values[1] = values[2] = 1;
    if (lua_getfield(L, -1, name) != LUA_TTABLE) {
        values[0] = launch_number(L, name);
        return 1;
    }
    lua_Unsigned n = lua_rawlen(L, -1);
    if (n < 1 || n > 3)
        luaL_error(L, "launch gives a list of %d for %s; expected 1 to 3 axes", (int)n, name);
    for (lua_Unsigned i = 0; i < n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        values[i] = launch_number(L, name);
    }
    lua_pop(L, 1);
    return (uint32_t)n;
}

static void read_axes(lua_State *L, bool asks, card_launch *launch)
{
    uint32_t groups[3], per_item[3];
    uint32_t n = launch_field(L, asks ? "group" : "WG", groups);
    uint32_t others = launch_field(L, asks ? "per_item" : "PER_ITEM", per_item);
    launch->n_axes = n > others ? n : others;
    for (int i = 0; i < 3; ++i)
        launch->axes[i] = (gen_axis){groups[i], per_item[i]};
}

// launch(p), where the card has it, else WG and PER_ITEM. A group above the device's limit is
// never valid.
static void ask_launch(lua_State *L, question *q)
{
    bool asks = lua_getfield(L, 2, "launch") == LUA_TFUNCTION;
    signature_push_config(L, q->config, q->card->n_params);
    if (asks)
        lua_call(L, 1, 1);
    if (lua_type(L, -1) != LUA_TTABLE)
        luaL_error(L, "launch gives a %s, not { group = ..., per_item = ... }",
                   luaL_typename(L, -1));
    read_axes(L, asks, &q->launch);
    double group = 1;
    for (int i = 0; i < 3; ++i)
        group *= q->launch.axes[i].group;
    q->is_valid = group <= q->limits->max_group;
    snprintf(q->reason, sizeof q->reason, "a group of %.0f is above the device's %" PRIu32, group,
             q->limits->max_group);
}

// [1] the question
static int check(lua_State *L)
{
    question *q = lua_touserdata(L, 1);
    lua_rawgeti(L, LUA_REGISTRYINDEX, q->card->table);
    ask_valid(L, q);
    if (q->is_valid)
        ask_launch(L, q);
    return 0;
}

static bool ask(lua_CFunction function, question *q, duet_error *err)
{
    lua_State *L = script_lua(q->card->script);
    lua_pushcfunction(L, function);
    lua_pushlightuserdata(L, q);
    return script_call(q->card->script, 1, 0, err);
}

bool card_judge(card *c, const gen_limits *limits, const gen_setting *config, bool *is_valid,
                duet_error *err)
{
    question q = {.card = c, .limits = limits, .config = config};
    bool ok = ask(check, &q, err);
    *is_valid = q.is_valid;
    return ok;
}

bool card_check(card *c, const gen_limits *limits, const gen_setting *config, card_launch *launch,
                duet_error *err)
{
    question q = {.card = c, .limits = limits, .config = config};
    if (!ask(check, &q, err))
        return false;
    *launch = q.launch;
    return q.is_valid || bad_argument(err, "%s: not a valid config: %s", c->kernel, q.reason);
}

// [1] the question
static int resolve(lua_State *L)
{
    question *q = lua_touserdata(L, 1);
    const card *c = q->card;
    for (uint32_t i = 0; i < c->n_signatures; ++i)
        signature_resolve(L, &c->signatures[i], q->config, c->n_params, &q->entries[i]);
    return 0;
}

static bool find_entries(card *c, const gen_setting *config, gen_variant *v, duet_error *err)
{
    v->n_entries = c->n_signatures;
    v->entries = calloc(c->n_signatures + 1, sizeof *v->entries);
    question q = {.card = c, .config = config, .entries = v->entries};
    return v->entries ? ask(resolve, &q, err) : no_memory(err, "%s", c->kernel);
}

static bool is_said(const gen_param *param, const gen_setting *setting)
{
    return !param->silent || setting->value != 0;
}

// Names what varies, in the card's order; a range is the scene's and not named.
static bool name_variant(const card *c, const gen_setting *config, gen_variant *v, duet_error *err)
{
    text name = {0};
    text_add(&name, "%s", c->kernel);
    for (uint32_t i = 0; i < c->n_params; ++i)
        if (c->params[i].n_values > 1 && is_said(&c->params[i], &config[i]))
            text_add(&name, ".%s%" PRId64, config[i].name, config[i].value);
    bool ok = text_ok(&name, err);
    if (ok && name.length >= sizeof v->name)
        ok =
            error_set(err, DUET_STATUS_BUILD_FAILED, "%s: a variant's name has at most %zu letters",
                      name.chars, sizeof v->name - 1);
    if (ok)
        memcpy(v->name, name.chars, name.length + 1);
    text_free(&name);
    return ok;
}

static void add_prelude(const card *c, const gen_setting *config, const gen_variant *v, text *out)
{
    text_add(out, "// %s\n", v->name);
    for (uint32_t i = 0; i < c->n_params; ++i) {
        bool negative = config[i].value < 0;
        if (!is_said(&c->params[i], &config[i]))
            continue;
        text_add(out, negative ? "#define %s (%" PRId64 ")\n" : "#define %s %" PRId64 "\n",
                 config[i].name, config[i].value);
    }
    if (v->n_entries > 0)
        signature_write(v->entries, v->n_entries, out);
    if (v->n_entries > 0 && c->has_struct)
        signature_write_fields(v->entries, v->n_entries, out);
}

bool card_resolve(card *c, const gen_limits *limits, const gen_setting *config,
                  gen_variant *variant, text *out, duet_error *err)
{
    card_launch launch;
    if (!card_check(c, limits, config, &launch, err) || !find_entries(c, config, variant, err) ||
        !name_variant(c, config, variant, err))
        return false;
    variant->group = launch.axes[0].group;
    variant->per_item = launch.axes[0].per_item;
    variant->n_axes = launch.n_axes;
    memcpy(variant->more, launch.axes + 1, sizeof variant->more);
    add_prelude(c, config, variant, out);
    return true;
}

// The parameter's default(limits), where it is a function. Its table is on top.
static void ask_fallback(lua_State *L, const question *q, gen_param *param)
{
    if (lua_getfield(L, -1, "default") == LUA_TFUNCTION) {
        push_limits(L, q->limits);
        lua_call(L, 1, 1);
        int whole = 0;
        param->fallback = lua_tointegerx(L, -1, &whole);
        if (!whole || !card_has_value(param, param->fallback))
            luaL_error(L, "%s: its default is %s, none of its values", param->name,
                       script_tostring(L, -1, NULL));
    }
    lua_pop(L, 1);
}

// [1] the question
static int fall_back(lua_State *L)
{
    question *q = lua_touserdata(L, 1);
    lua_rawgeti(L, LUA_REGISTRYINDEX, q->card->table);
    lua_getfield(L, -1, "params");
    for (uint32_t i = 0; i < q->card->n_params; ++i) {
        lua_geti(L, -1, (lua_Integer)i + 1);
        ask_fallback(L, q, &q->card->params[i]);
        lua_pop(L, 1);
    }
    return 0;
}

bool card_set_fallbacks(card *c, const gen_limits *limits, duet_error *err)
{
    question q = {.card = c, .limits = limits};
    return ask(fall_back, &q, err);
}

bool card_fill(card *c, const gen_offer *offers, uint32_t n, const gen_limits *limits,
               gen_setting *config, duet_error *err)
{
    bool ok = card_set_fallbacks(c, limits, err);
    for (uint32_t i = 0; ok && i < c->n_params; ++i)
        config[i] = (gen_setting){c->params[i].name, c->params[i].fallback};
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = card_take(c, &offers[i], config, err);
    return ok;
}
