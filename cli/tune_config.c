// SPDX-License-Identifier: MIT
#include "cli/tune_config.h"

#include "base/text_file.h"
#include "gen/field.h"
#include "gen/sandbox.h"
#include "runtime/broadphase/variant.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/shipped.h"
#include "tuner/strategy.h"

#include <float.h>
#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

// While reading: 1 what the file returned, 2 the config, 3 a list that keeps
// strings which are made here.
enum { ROOT = 1, CONFIG = 2, KEPT = 3 };

static const char *keep_string(lua_State *L)
{
    const char *string = lua_tostring(L, -1);
    lua_rawseti(L, KEPT, (lua_Integer)lua_rawlen(L, KEPT) + 1);
    return string;
}

// ---------------------------------------------------------------- workloads

// The path as it is, or in the folder that the file lies in.
static const char *find_path(lua_State *L, const char *path)
{
    const char *file = NULL;
    script_chunk(L, &file);
    const char *slash = file ? strrchr(file, '/') : NULL;
    if (path[0] == '/' || !slash)
        return path;
    lua_pushlstring(L, file, (size_t)(slash - file) + 1);
    lua_pushstring(L, path);
    lua_concat(L, 2);
    return keep_string(L);
}

static void settle_paths(lua_State *L, config_workload *w)
{
    shipped_scene shipped;
    if (!w->scene == !w->task)
        field_raise(L, "workloads", "a workload needs a scene or a task, the path of a file%s",
                    w->task ? "; this one has both" : "");
    if (w->task)
        w->task = find_path(L, w->task);
    else if (!shipped_find(w->scene, &shipped))
        w->scene = find_path(L, w->scene);
}

static int compare_strings(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

// In order of their names: a table's own order changes from run to run.
static void read_settings(lua_State *L, const field *f, void *at)
{
    config_workload *w = at;
    if (!lua_istable(L, -1))
        field_refuse(L, f, "a table");
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING || w->n_settings == CONFIG_SETTINGS)
            field_raise(L, "set", "set is up to %d parameters of the scene or task, by name",
                        CONFIG_SETTINGS);
        const char *value = script_tostring(L, -1, NULL);
        lua_pushfstring(L, "%s=%s", lua_tostring(L, -3), value);
        w->settings[w->n_settings++] = keep_string(L);
        lua_pop(L, 1);
    }
    qsort(w->settings, w->n_settings, sizeof w->settings[0], compare_strings);
}

static const field workload_fields[] = {
    FIELDS(config_workload, scene, task),
    {.name = "set", .type = &(const field_type){.read = read_settings}},
    FIELDS(config_workload, query),
    FIELD_WITHIN(config_workload, , items, 0, UINT32_MAX, "a number of rays, boxes ... of a query"),
    FIELD_WITHIN(config_workload, , steps, 2, UINT32_MAX, "a number of 2 or more"),
    {.name = "n", .type = &field_unread},
    {0},
};

static void check_query(lua_State *L, const config_workload *w)
{
    if (w->task && w->query)
        field_raise(L, "query", "a task has no query; expected a scene");
    if (w->items > 0 && !w->query)
        field_raise(L, "items", "items is a number of rays, boxes ... of a query");
    if (w->steps > 0 && (w->query || w->task))
        field_raise(L, "steps", "steps is a number of 2 or more, of a scene without a query");
}

// n is on top of the stack.
static void add_workload(lua_State *L, tune_config *c, const config_workload *w)
{
    int whole = 0;
    lua_Integer n = lua_type(L, -1) == LUA_TNUMBER ? lua_tointegerx(L, -1, &whole) : 0;
    n = lua_isnil(L, -1) ? -1 : whole ? n : -2;
    if (c->n_workloads == CONFIG_WORKLOADS)
        field_raise(L, "workloads", "at most %d workloads, each n counting", CONFIG_WORKLOADS);
    if (n < -1 || n > UINT32_MAX)
        field_raise(L, "n", "n is a number of objects, or a list of them");
    c->workloads[c->n_workloads] = *w;
    c->workloads[c->n_workloads++].n = n;
}

// Number i of the list on top of the stack.
static void read_workload(lua_State *L, lua_Integer i, tune_config *c)
{
    config_workload w = {0};
    lua_rawgeti(L, -1, i);
    field_read_row(L, -1, (field_table){"workload", i}, workload_fields, &w);
    settle_paths(L, &w);
    check_query(L, &w);
    lua_getfield(L, -1, "n");
    if (!lua_istable(L, -1))
        add_workload(L, c, &w);
    for (lua_Integer k = 1; lua_istable(L, -1) && k <= (lua_Integer)lua_rawlen(L, -1); ++k) {
        lua_rawgeti(L, -1, k);
        add_workload(L, c, &w);
        lua_pop(L, 1);
    }
    lua_pop(L, 2);
}

static void read_workloads(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    if (!lua_istable(L, -1))
        field_refuse(L, f, "a list of {scene = ..., n = ...}");
    for (lua_Integer i = 1; i <= (lua_Integer)lua_rawlen(L, -1); ++i)
        read_workload(L, i, c);
}

// ---------------------------------------------------------------- the rest

static void read_strategy(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    if (lua_isfunction(L, -1)) {
        c->def.strategy = strategy_lua.name;
        c->def.strategy_lua = text_chars(&c->text);
        return;
    }
    field_string.read(L, f, &c->def.strategy);
    if (!strategy_find(c->def.strategy))
        field_raise(L, "strategy", "there is no strategy '%s'; a function may also be given",
                    c->def.strategy);
}

static void read_objective(lua_State *L, const field *f, void *at)
{
    const char *objective = NULL;
    field_string.read(L, f, &objective);
    if (strcmp(objective, "time") != 0 && strcmp(objective, "energy") != 0)
        field_raise(L, "objective", "there is no objective '%s'; expected 'time' or 'energy'",
                    objective);
    *(const char **)at = objective;
}

static void read_modes(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    field_name_list list;
    field_names.read(L, f, &list);
    if (list.n > CONFIG_MODES)
        field_raise(L, "modes", "modes is a list of %u; expected at most %d", list.n, CONFIG_MODES);
    c->def.n_modes = list.n;
    for (uint32_t i = 0; i < list.n; ++i)
        if (!mode_from_name(list.names[i], &c->modes[i]))
            field_raise(L, "modes", "there is no mode '%s'", list.names[i]);
}

// level = "sat6", or a list of levels that accuracy chooses from.
static void read_levels(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    field_name_list list = {.n = 1};
    if (lua_istable(L, -1))
        field_names.read(L, f, &list);
    else
        field_string.read(L, f, &list.names[0]);
    if (list.n > DUET_LEVELS)
        field_raise(L, "level", "level is a list of %u; expected at most %d", list.n, DUET_LEVELS);
    c->def.n_levels = list.n;
    for (uint32_t i = 0; i < list.n; ++i)
        if (!duet_level_from_name(list.names[i], &c->levels[i]))
            field_raise(L, "level", "there is no level '%s'", list.names[i]);
}

static void read_accuracy(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    field_accuracy.read(L, f, &c->def.accuracy);
    c->def.has_accuracy = true;
}

#define A_COUNT "a number from 0 to 2147483647"

static const field budget_fields[] = {
    {FIELD_ROW("seconds", field_double, duet_tune_def, budget_seconds), .most = DBL_MAX,
     .expected = "a time from 0 on"},
    {FIELD_ROW("trials", field_count, duet_tune_def, budget_trials), .most = INT32_MAX,
     .expected = A_COUNT},
    {0},
};

static void read_budget(lua_State *L, const field *f, void *at)
{
    (void)f;
    field_read_row(L, -1, (field_table){"budget", -1}, budget_fields, at);
}

#define READ_BY(name_, reader)                       \
    {                                                \
        .name = (name_), .type = &(const field_type) \
        {                                            \
            .read = (reader)                         \
        }                                            \
    }

static const field config_fields[] = {
    READ_BY("workloads", read_workloads),
    FIELDS(tune_config, pair),
    READ_BY("strategy", read_strategy),
    FIELDS(tune_config, variants),
    FIELDS_IN(tune_config, def., search),
    READ_BY("modes", read_modes),
    FIELD_AT("budget", (const field_type){.read = read_budget}, tune_config, def),
    FIELD_WITHIN(tune_config, def., repeats, 0, 32, "a number from 0 to 32"),
    FIELD_WITHIN(tune_config, def., seed, 0, INT32_MAX, A_COUNT),
    FIELD_AT("objective", (const field_type){.read = read_objective}, tune_config, def.objective),
    READ_BY("level", read_levels),
    READ_BY("accuracy", read_accuracy),
    {0},
};

// root, config -> the list that keeps strings
static int read_config(lua_State *L)
{
    tune_config *c = lua_touserdata(L, CONFIG);
    lua_newtable(L);
    if (!lua_istable(L, ROOT))
        return field_raise(L, NULL, "a tune file returns a table, not %s", luaL_typename(L, ROOT));
    field_read(L, ROOT, "a tune file", config_fields, c);
    if (c->n_workloads == 0)
        field_raise(L, "workloads", "workloads are missing: a list of {scene = ..., n = ...}");
    if (c->def.n_levels > 1 && !c->def.has_accuracy)
        field_raise(L, "level", "several levels need an accuracy that one is chosen by");
    c->def.n_variants = c->variants.n;
    lua_settop(L, KEPT);
    return 1;
}

void tune_config_begin(tune_config *c)
{
    *c = (tune_config){.def = duet_default_tune_def()};
    c->def.variants = c->variants.names;
    c->def.modes = c->modes;
    c->def.levels = c->levels;
}

bool tune_config_load(tune_config *c, const char *path, duet_error *err)
{
    tune_config_begin(c);
    c->script = sandbox_open(NULL, err);
    bool ok = c->script && text_read_lines(&c->text, path, err) &&
              script_run(c->script, path, text_chars(&c->text), c->text.length, 1, err);
    if (ok) {
        lua_State *L = script_lua(c->script);
        lua_pushcfunction(L, read_config);
        lua_pushvalue(L, ROOT); // the original stays and keeps its strings
        lua_pushlightuserdata(L, c);
        ok = script_call(c->script, 2, 1, err);
    }
    if (!ok)
        tune_config_free(c);
    return ok;
}

void tune_config_free(tune_config *c)
{
    script_close(c->script);
    text_free(&c->text);
    text_free(&c->list);
    *c = (tune_config){0};
}
