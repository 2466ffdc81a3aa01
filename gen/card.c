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
        script_lacks_memory(L);
    return memcpy(copy, chars, bytes);
}

static bool is_param_name(const char *name)
{
    bool begins = *name >= 'A' && *name <= 'Z';
    return begins && strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == strlen(name);
}

static void read_about(lua_State *L, const field *f, void *at)
{
    const char *about = NULL;
    field_string.read(L, f, &about);
    *(char **)at = copy_string(L, about);
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

static void read_values(lua_State *L, const field *f, void *at)
{
    gen_param *param = at;
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (n == 0 || n > 1000)
        field_refuse(L, f, "a list of 1 to 1000 whole numbers");
    int64_t *values = malloc(n * sizeof *values);
    if (!values)
        script_lacks_memory(L);
    param->values = values;
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        read_value(L, param, values);
        lua_pop(L, 1);
    }
}

static void check_range(lua_State *L, const gen_param *param)
{
    if (param->least > param->most)
        field_raise(L, NULL, "%s: min %" PRId64 " is above max %" PRId64, param->name, param->least,
                    param->most);
    if (!param->is_range && param->n_values == 0)
        field_raise(L, NULL, "%s: neither values nor min and max say what it can be", param->name);
}

// The first value by default. A function's is asked for each device (card_ask.c).
static void read_fallback(lua_State *L, gen_param *param)
{
    const field_table table = {param->name, -1, NULL};
    const field fallback = {FIELD_ROW("default", field_int, gen_param, fallback), .table = &table};
    param->fallback = param->n_values > 0 ? param->values[0] : param->least;
    bool computed = lua_getfield(L, -1, "default") == LUA_TFUNCTION;
    lua_pop(L, 1);
    if (computed)
        return;
    field_read_one(L, -1, &fallback, param);
    if (!card_has_value(param, param->fallback))
        field_raise(L, NULL, "%s: its default %" PRId64 " is not one of its values", param->name,
                    param->fallback);
}

static const field param_fields[] = {
    {.name = "[1]", .type = &field_unread},
    {.name = "values", .type = &(const field_type){.read = read_values}},
    FIELD_AT("min", field_int, gen_param, least),
    FIELD_AT("max", field_int, gen_param, most),
    {.name = "default", .type = &field_unread},
    FIELDS(gen_param, silent),
    FIELD((const field_type){.read = read_about}, gen_param, about),
    {0},
};

static void read_param(lua_State *L, card *c)
{
    gen_param *param = &c->params[c->n_params];
    if (lua_type(L, -1) != LUA_TTABLE)
        field_raise(L, "params", "parameter %u is a %s, not a table", c->n_params + 1,
                    luaL_typename(L, -1));
    read_param_name(L, c, param);
    ++c->n_params;
    param->least = INT64_MIN;
    param->most = INT64_MAX;
    field_read_row(L, -1, (field_table){param->name, -1, NULL}, param_fields, param);
    param->is_range = param->least != INT64_MIN || param->most != INT64_MAX;
    check_range(L, param);
    read_fallback(L, param);
    if (!param->about)
        param->about = copy_string(L, "");
}

static void read_params(lua_State *L, const field *f, void *at)
{
    card *c = at;
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : CARD_MAX_PARAMS + 1;
    if (n > CARD_MAX_PARAMS)
        field_refuse(L, f, "a list of at most 32 parameters");
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        read_param(L, c);
        lua_pop(L, 1);
    }
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

static void read_names(lua_State *L, const field *f, void *at)
{
    card_names *names = at;
    if (!lua_istable(L, -1))
        field_refuse(L, f, "a list of files' names");
    for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i, lua_pop(L, 1)) {
        size_t length = 0;
        const char *name = lua_tolstring(L, -1, &length);
        if (!name || !is_file_name(name, length) || names->n == CARD_MAX_NAMES)
            field_raise(L, f->name, "%s has at most %d names of files, in small letters", f->name,
                        CARD_MAX_NAMES);
        memcpy(names->at[names->n++], name, length + 1);
    }
    lua_pop(L, 1);
}

static void read_signatures(lua_State *L, const field *f, void *at)
{
    card *c = at;
    if (!lua_istable(L, -1))
        field_refuse(L, f, "a table of entries");
    signature_read(L, &c->signatures, &c->n_signatures);
}

static void read_function(lua_State *L, const field *f, void *at)
{
    bool has = false;
    (void)at;
    field_function.read(L, f, &has);
}

#define CARD_FIELD(name_, reader)                    \
    {                                                \
        .name = (name_), .type = &(const field_type) \
        {                                            \
            .read = (reader)                         \
        }                                            \
    }

enum { HAS_PARAMS = 2, HAS_LAUNCH = 4 };

static const field card_fields[] = {
    FIELD((const field_type){.read = read_about}, card, about),
    CARD_FIELD("params", read_params),
    CARD_FIELD("launch", read_function),
    CARD_FIELD("args", read_signatures),
    CARD_FIELD("valid", read_function),
    FIELD((const field_type){.read = read_names}, card, uses),
    FIELD((const field_type){.read = read_names}, card, emit),
    {0},
};

// [1] what the card returned, [2] the card to fill
static int read_card(lua_State *L)
{
    card *c = lua_touserdata(L, 2);
    if (lua_type(L, 1) != LUA_TTABLE)
        field_raise(L, NULL, "the card returns a %s, not a table", luaL_typename(L, 1));
    uint64_t given = field_read(L, 1, "the card", card_fields, c);
    if (!(given & HAS_PARAMS))
        field_raise(L, NULL, "the card has no params");
    if (!(given & HAS_LAUNCH) && !(card_param(c, "WG") && card_param(c, "PER_ITEM")))
        field_raise(L, NULL, "the card has no launch function, nor WG and PER_ITEM");
    if (!c->about)
        c->about = copy_string(L, "");
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
