// SPDX-License-Identifier: MIT
// Reads a card once and asks its functions later. A config reaches them as a
// table with a field for each parameter.
#include "gen/card.h"
#include "base/blob.h"
#include "gen/field.h"
#include "gen/sandbox.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CONFIGS (UINT64_C(1) << 20)

// ---------------------------------------------------------------- reading

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

static const gen_param *find_param(const card *c, const char *name)
{
    for (uint32_t i = 0; i < c->n_params; ++i)
        if (strcmp(c->params[i].name, name) == 0)
            return &c->params[i];
    return NULL;
}

// The name at [1] of the table on top.
static void read_param_name(lua_State *L, card *c, gen_param *param)
{
    const char *name = lua_rawgeti(L, -1, 1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
    if (!is_param_name(name))
        field_raise(L, "params", "parameter %u begins with '%s', not with its NAME in capitals",
                    c->n_params + 1, name);
    if (find_param(c, name))
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

static bool has_value(const gen_param *param, int64_t value)
{
    if (param->is_range)
        return value >= param->least && value <= param->most;
    for (uint32_t i = 0; i < param->n_values; ++i)
        if (param->values[i] == value)
            return true;
    return false;
}

// A number is checked here, a function when it is asked.
static void read_fallback(lua_State *L, gen_param *param)
{
    if (lua_getfield(L, -1, "default") != LUA_TFUNCTION) {
        lua_Integer first = param->n_values > 0 ? param->values[0] : param->least;
        param->fallback = field_integer(L, -2, "default", first);
        if (!has_value(param, param->fallback))
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
    if (card_size(c) > MAX_CONFIGS)
        field_raise(L, "params", "more than %" PRIu64 " configs: leave values out", MAX_CONFIGS);
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
    if (!has_function(L, "launch") && !(find_param(c, "WG") && find_param(c, "PER_ITEM")))
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

// ---------------------------------------------------------------- asking

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

bool card_check(card *c, const gen_limits *limits, const gen_setting *config, card_launch *launch,
                duet_error *err)
{
    question q = {.card = c, .limits = limits, .config = config};
    if (!ask(check, &q, err))
        return false;
    *launch = q.launch;
    return q.is_valid || error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: not a valid config: %s",
                                   c->kernel, q.reason);
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
    return v->entries ? ask(resolve, &q, err)
                      : error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory", c->kernel);
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
        if (!whole || !has_value(param, param->fallback))
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

// ---------------------------------------------------------------- values

static bool check_value(const card *c, const gen_param *param, int64_t value, duet_error *err)
{
    if (has_value(param, value))
        return true;
    if (param->is_range)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: %s=%" PRId64 " is not in %" PRId64 " .. %" PRId64, c->kernel,
                         param->name, value, param->least, param->most);
    text all = {0};
    for (uint32_t i = 0; i < param->n_values; ++i)
        text_add(&all, "%s%" PRId64, i > 0 ? ", " : "", param->values[i]);
    error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: %s=%" PRId64 " is not one of %s", c->kernel,
              param->name, value, text_chars(&all));
    text_free(&all);
    return false;
}

static bool refuse_name(const card *c, const char *name, duet_error *err)
{
    text all = {0};
    for (uint32_t i = 0; i < c->n_params; ++i)
        text_add(&all, "%s%s", i > 0 ? ", " : "", c->params[i].name);
    error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: no parameter '%s': there are %s", c->kernel, name,
              text_chars(&all));
    text_free(&all);
    return false;
}

static bool take(const card *c, const gen_offer *offer, gen_setting *config, duet_error *err)
{
    const gen_param *param = find_param(c, offer->name);
    if (offer->kernel && *offer->kernel && strcmp(offer->kernel, c->kernel) != 0)
        return true;
    if (!param)
        return offer->manner != GEN_REQUIRED || refuse_name(c, offer->name, err);
    int64_t greatest = param->is_range ? param->most : param->values[param->n_values - 1];
    bool above = offer->manner == GEN_CAPPED && offer->value > greatest;
    int64_t *value = &config[param - c->params].value;
    *value = above ? greatest : offer->value;
    if (offer->taken)
        *offer->taken = true;
    return check_value(c, param, *value, err);
}

bool card_fill(card *c, const gen_offer *offers, uint32_t n, const gen_limits *limits,
               gen_setting *config, duet_error *err)
{
    bool ok = card_set_fallbacks(c, limits, err);
    for (uint32_t i = 0; ok && i < c->n_params; ++i)
        config[i] = (gen_setting){c->params[i].name, c->params[i].fallback};
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = take(c, &offers[i], config, err);
    return ok;
}

// A range without values does not vary by itself.
static uint32_t radix(const gen_param *param)
{
    return param->n_values > 0 ? param->n_values : 1;
}

uint64_t card_size(const card *c)
{
    uint64_t size = 1;
    for (uint32_t i = 0; i < c->n_params && size <= MAX_CONFIGS; ++i)
        size *= radix(&c->params[i]);
    return size;
}

void card_config(const card *c, uint64_t index, gen_setting *config)
{
    for (uint32_t i = c->n_params; i-- > 0;) {
        const gen_param *param = &c->params[i];
        uint32_t digit = (uint32_t)(index % radix(param));
        index /= radix(param);
        config[i].name = param->name;
        config[i].value = param->n_values > 0 ? param->values[digit] : param->fallback;
    }
}
