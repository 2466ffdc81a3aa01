// SPDX-License-Identifier: MIT
// Reads a card, once.
#include "gen/card.h"
#include "base/blob.h"
#include "gen/field.h"
#include "gen/sandbox.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

static char *copy_string(lua_State *L, const char *chars)
{
    size_t bytes = strlen(chars) + 1;
    char *copy = malloc(bytes);
    if (!copy)
        luaL_error(L, "no memory");
    return memcpy(copy, chars, bytes);
}

static bool is_param_name(const char *name)
{
    bool begins = *name >= 'A' && *name <= 'Z';
    return begins && strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == strlen(name);
}

// The name at [1] of the table on top.
static void read_param_name(lua_State *L, card *c, gen_param *param)
{
    const char *name = lua_rawgeti(L, -1, 1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
    if (!is_param_name(name))
        field_raise(L, "params", "parameter %u begins with '%s', not with its NAME in capitals",
                    c->n_params + 1, name);
    if (card_param(c, name))
        field_raise(L, "params", "parameter %s is there twice", name);
    param->name = copy_string(L, name);
    lua_pop(L, 1);
    lua_pushnil(L);
    lua_rawseti(L, -2, 1); // so that only named fields are left
}

static void read_value(lua_State *L, gen_param *param, int64_t *values)
{
    int whole = 0;
    int64_t value = lua_tointegerx(L, -1, &whole);
    if (!whole || lua_type(L, -1) != LUA_TNUMBER)
        field_raise(L, NULL, "%s: value %u is not a whole number", param->name,
                    param->n_values + 1);
    for (uint32_t i = 0; i < param->n_values; ++i)
        if (values[i] == value)
            field_raise(L, NULL, "%s: value %" PRId64 " is there twice", param->name, value);
    values[param->n_values++] = value;
}

static void read_values(lua_State *L, gen_param *param)
{
    if (!field_push(L, -1, "values", LUA_TTABLE))
        return;
    lua_Unsigned n = lua_rawlen(L, -1);
    if (n == 0 || n > 1000)
        field_raise(L, NULL, "%s: values has %d of them, not 1 to 1000", param->name, (int)n);
    int64_t *values = malloc(n * sizeof *values);
    if (!values)
        luaL_error(L, "no memory");
    param->values = values;
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        read_value(L, param, values);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

static void read_range(lua_State *L, gen_param *param)
{
    param->least = field_integer(L, -1, "min", INT64_MIN);
    param->most = field_integer(L, -1, "max", INT64_MAX);
    param->is_range = param->least != INT64_MIN || param->most != INT64_MAX;
    if (param->least > param->most)
        field_raise(L, NULL, "%s: min %" PRId64 " is above max %" PRId64, param->name, param->least,
                    param->most);
    if (!param->is_range && param->n_values == 0)
        field_raise(L, NULL, "%s: neither values nor min and max say what it can be", param->name);
}

static void read_fallback(lua_State *L, gen_param *param)
{
    if (lua_getfield(L, -1, "default") != LUA_TFUNCTION) {
        lua_Integer first = param->n_values > 0 ? param->values[0] : param->least;
        param->fallback = field_integer(L, -2, "default", first);
        if (!card_has_value(param, param->fallback))
            field_raise(L, NULL, "%s: its default %" PRId64 " is not one of its values",
                        param->name, param->fallback);
    }
    lua_pop(L, 1);
}

static void read_param(lua_State *L, card *c)
{
    static const char *const names[] = {"values", "min", "max", "default", "silent", "about", NULL};
    gen_param *param = &c->params[c->n_params];
    if (lua_type(L, -1) != LUA_TTABLE)
        field_raise(L, "params", "parameter %u is a %s, not a table", c->n_params + 1,
                    luaL_typename(L, -1));
    read_param_name(L, c, param);
    ++c->n_params;
    field_only(L, -1, param->name, names);
    read_values(L, param);
    read_range(L, param);
    read_fallback(L, param);
    param->silent = field_boolean(L, -1, "silent", false);
    param->about = copy_string(L, field_string(L, -1, "about", ""));
}

static void read_params(lua_State *L, card *c)
{
    if (!field_push(L, 1, "params", LUA_TTABLE))
        field_raise(L, NULL, "the card has no params");
    lua_Unsigned n = lua_rawlen(L, -1);
    if (n > CARD_MAX_PARAMS)
        field_raise(L, "params", "%d parameters, at most %d", (int)n, CARD_MAX_PARAMS);
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        read_param(L, c);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    if (card_size(c) > CARD_MAX_CONFIGS)
        field_raise(L, "params", "more than %" PRIu64 " configs: leave values out",
                    CARD_MAX_CONFIGS);
}

// A file beside the card, never one elsewhere.
// NAME or FOLDER/NAME, neither of which begins with a dot.
static bool is_file_name(const char *name, size_t length)
{
    const char *slash = memchr(name, '/', length);
    const char *last = slash ? slash + 1 : name;
    return length > 0 && length < 64 && *name != '.' && *name != '/' && *last != '.' && *last &&
           !strchr(last, '/') && strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_./") == length;
}

static void read_names(lua_State *L, const char *field, card_names *names)
{
    if (!field_push(L, 1, field, LUA_TTABLE))
        return;
    for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i, lua_pop(L, 1)) {
        size_t length = 0;
        const char *name = lua_tolstring(L, -1, &length);
        if (!name || !is_file_name(name, length) || names->n == CARD_MAX_NAMES)
            field_raise(L, field, "%s has at most %d names of files, in small letters", field,
                        CARD_MAX_NAMES);
        memcpy(names->at[names->n++], name, length + 1);
    }
    lua_pop(L, 2);
}

static bool has_function(lua_State *L, const char *name)
{
    bool has = field_push(L, 1, name, LUA_TFUNCTION);
    if (has)
        lua_pop(L, 1);
    return has;
}

// [1] what the card returned, [2] the card to fill
static int read_card(lua_State *L)
{
    static const char *const names[] = {"about",  "params", "args", "valid",
                                        "launch", "uses",   "emit", NULL};
    card *c = lua_touserdata(L, 2);
    if (lua_type(L, 1) != LUA_TTABLE)
        field_raise(L, NULL, "the card returns a %s, not a table", luaL_typename(L, 1));
    field_only(L, 1, "the card", names);
    c->about = copy_string(L, field_string(L, 1, "about", ""));
    read_params(L, c);
    read_names(L, "uses", &c->uses);
    read_names(L, "emit", &c->emit);
    signature_read(L, 1, &c->signatures, &c->n_signatures);
    has_function(L, "valid");
    if (!has_function(L, "launch") && !(card_param(c, "WG") && card_param(c, "PER_ITEM")))
        field_raise(L, NULL, "the card has no launch function, nor WG and PER_ITEM");
    lua_pushvalue(L, 1);
    c->table = luaL_ref(L, LUA_REGISTRYINDEX);
    return 0;
}

// Gives the card's script what parameters of many cards are.
static bool run_common(script *s, duet_error *err)
{
    const blob *b = blob_find("gen/common.lua");
    return script_run(s, "gen/common.lua", b->bytes, b->length, 0, err);
}

bool card_open(card *c, const char *kernel, const char *path, const text *chars, duet_error *err)
{
    script_limits limits = script_default_limits();
    limits.failure = DUET_STATUS_BUILD_FAILED;
    *c = (card){.kernel = kernel};
    c->script = sandbox_open(&limits, err);
    bool ok = c->script && run_common(c->script, err) &&
              script_run(c->script, path, chars->chars, chars->length, 1, err);
    if (ok) {
        lua_State *L = script_lua(c->script);
        lua_pushcfunction(L, read_card);
        lua_insert(L, 1);
        lua_pushlightuserdata(L, c);
        ok = script_call(c->script, 2, 0, err);
    }
    if (!ok)
        card_close(c);
    return ok;
}

void card_close(card *c)
{
    for (uint32_t i = 0; i < CARD_MAX_PARAMS; ++i) {
        free((void *)c->params[i].name);
        free((void *)c->params[i].about);
        free((void *)c->params[i].values);
    }
    free(c->about);
    free(c->signatures);
    script_close(c->script);
    *c = (card){0};
}
