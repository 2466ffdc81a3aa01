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

static void settle_paths(lua_State *L, const field_table *row, config_workload *w)
{
    shipped_scene shipped;
    if (!w->scene == !w->task)
        field_raise_in(L, row, w->task ? "task" : NULL,
                       "%s; expected a scene or a task, the path of a file",
                       w->task ? "it has a scene and a task" : "it has no scene and no task");
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
        const char *name = field_text(L, -2);
        if (!name || w->n_settings == CONFIG_SETTINGS)
            field_raise_in(L, f->table, f->name,
                           "set is up to %d parameters of the scene or task, by name",
                           CONFIG_SETTINGS);
        size_t length = 0;
        const char *value = script_tostring(L, -1, &length);
        if (strlen(value) < length)
            field_raise_in(L, f->table, f->name, "set: %s is '%s'; expected a value without NUL",
                           name, field_push_shown(L, -1));
        lua_pushfstring(L, "%s=%s", name, value);
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

static void check_query(lua_State *L, const field_table *row, const config_workload *w)
{
    if (w->task && w->query)
        field_raise_in(L, row, "query", "a task has no query; expected a scene");
    if (w->items > 0 && !w->query)
        field_raise_in(L, row, "items", "items is a number of rays, boxes ... of a query");
    if (w->steps > 0 && (w->query || w->task))
        field_raise_in(L, row, "steps",
                       "steps is a number of 2 or more, of a scene without a query");
}

// n is on top of the stack; -1 for none.
static void add_workload(lua_State *L, const field_table *row, tune_config *c,
                         const config_workload *w)
{
    const field n = {.name = "n",
                     .table = row,
                     .size = sizeof w->n,
                     .most = UINT32_MAX,
                     .expected = "a number of objects, or a list of them"};
    if (c->n_workloads == CONFIG_WORKLOADS)
        field_raise(L, "workloads", "at most %d workloads, each n counting", CONFIG_WORKLOADS);
    config_workload *added = &c->workloads[c->n_workloads++];
    *added = *w;
    added->n = -1;
    if (!lua_isnil(L, -1))
        field_int.read(L, &n, &added->n);
}

// Number i of the list on top of the stack.
static void read_workload(lua_State *L, lua_Integer i, tune_config *c)
{
    const field_table row = {"workload", i, "workloads"};
    config_workload w = {0};
    lua_rawgeti(L, -1, i);
    field_read_row(L, -1, row, workload_fields, &w);
    settle_paths(L, &row, &w);
    check_query(L, &row, &w);
    lua_getfield(L, -1, "n");
    if (!lua_istable(L, -1))
        add_workload(L, &row, c, &w);
    for (lua_Integer k = 1; lua_istable(L, -1) && k <= (lua_Integer)lua_rawlen(L, -1); ++k) {
        lua_rawgeti(L, -1, k);
        add_workload(L, &row, c, &w);
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
    duet_error why = {0};
    if (!strategy_check(c->def.strategy, &why))
        field_raise(L, "strategy", "%s; a function may also be given", why.text);
}

static void read_objective(lua_State *L, const field *f, void *at)
{
    const char *objective = NULL;
    field_string.read(L, f, &objective);
    if (strcmp(objective, "time") != 0 && strcmp(objective, "energy") != 0)
        field_refuse(L, f, "time or energy");
    *(const char **)at = objective;
}

static void read_modes(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    field_enum_list list;
    field_enums.read(L, f, &list);
    for (c->def.n_modes = 0; c->def.n_modes < list.n; ++c->def.n_modes)
        c->modes[c->def.n_modes] = (duet_mode)list.values[c->def.n_modes];
}

// level = "sat6", or a list of levels that accuracy chooses from.
static void read_levels(lua_State *L, const field *f, void *at)
{
    tune_config *c = at;
    field_enum_list list;
    field_enums.read(L, f, &list);
    for (c->def.n_levels = 0; c->def.n_levels < list.n; ++c->def.n_levels)
        c->levels[c->def.n_levels] = (duet_level)list.values[c->def.n_levels];
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
    field_read_row(L, -1, (field_table){"budget", -1, NULL}, budget_fields, at);
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
    {.name = "modes", .type = &(const field_type){.read = read_modes}, .name_of = mode_to_search_name},
    FIELD_AT("budget", (const field_type){.read = read_budget}, tune_config, def),
    FIELD_WITHIN(tune_config, def., repeats, 0, 32, "a number from 0 to 32"),
    FIELD_WITHIN(tune_config, def., seed, 0, INT32_MAX, A_COUNT),
    FIELD_AT("objective", (const field_type){.read = read_objective}, tune_config, def.objective),
    {.name = "level", .type = &(const field_type){.read = read_levels}, .name_of = level_name},
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
