// SPDX-License-Identifier: MIT
#include "cli/tune_config.h"

#include "base/text_file.h"
#include "gen/field.h"
#include "gen/sandbox.h"
#include "runtime/broadphase/variant.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/shipped.h"
#include "tuner/strategy.h"

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

static void read_paths(lua_State *L, int table, config_workload *w)
{
    shipped_scene shipped;
    w->scene = field_string(L, table, "scene", NULL);
    w->task = field_string(L, table, "task", NULL);
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
static void read_settings(lua_State *L, int table, config_workload *w)
{
    if (!field_push(L, table, "set", LUA_TTABLE))
        return;
    int set = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, set); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING || w->n_settings == CONFIG_SETTINGS)
            field_raise(L, "set", "set is up to %d parameters of the scene or task, by name",
                        CONFIG_SETTINGS);
        const char *value = script_tostring(L, -1, NULL);
        lua_pushfstring(L, "%s=%s", lua_tostring(L, -3), value);
        w->settings[w->n_settings++] = keep_string(L);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    qsort(w->settings, w->n_settings, sizeof w->settings[0], compare_strings);
}

static void read_query(lua_State *L, int table, config_workload *w)
{
    int64_t items = field_integer(L, table, "items", 0);
    w->query = field_string(L, table, "query", NULL);
    if (w->task && w->query)
        field_raise(L, "query", "a task has no query; expected a scene");
    if (items < 0 || items > UINT32_MAX || (items > 0 && !w->query))
        field_raise(L, "items", "items is a number of rays, boxes ... of a query");
    w->items = (uint64_t)items;
}

static void read_steps(lua_State *L, int table, config_workload *w)
{
    int64_t steps = field_integer(L, table, "steps", 0);
    if (steps < 0 || steps == 1 || steps > UINT32_MAX || (steps > 0 && (w->query || w->task)))
        field_raise(L, "steps", "steps is a number of 2 or more, of a scene without a query");
    w->steps = (uint32_t)steps;
}

static void add_workload(lua_State *L, tune_config *c, const config_workload *w, int64_t n)
{
    if (c->n_workloads == CONFIG_WORKLOADS)
        field_raise(L, "workloads", "at most %d workloads, each n counting", CONFIG_WORKLOADS);
    if (n < -1 || n > UINT32_MAX)
        field_raise(L, "n", "n is a number of objects, or a list of them");
    c->workloads[c->n_workloads] = *w;
    c->workloads[c->n_workloads++].n = n;
}

static void read_workload(lua_State *L, int table, tune_config *c)
{
    static const char *const names[] = {"scene", "task",  "n",     "set",
                                        "query", "items", "steps", NULL};
    config_workload w = {0};
    field_only(L, table, "a workload", names);
    read_paths(L, table, &w);
    read_settings(L, table, &w);
    read_query(L, table, &w);
    read_steps(L, table, &w);
    lua_getfield(L, table, "n");
    if (!lua_istable(L, -1)) {
        lua_pop(L, 1);
        add_workload(L, c, &w, field_integer(L, table, "n", -1));
        return;
    }
    for (lua_Integer i = 1; i <= (lua_Integer)lua_rawlen(L, -1); ++i) {
        lua_rawgeti(L, -1, i);
        add_workload(L, c, &w, lua_isinteger(L, -1) ? lua_tointeger(L, -1) : -2);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

static void read_workloads(lua_State *L, tune_config *c)
{
    if (!field_push(L, ROOT, "workloads", LUA_TTABLE))
        field_raise(L, NULL, "workloads are missing: a list of {scene = ..., n = ...}");
    int list = lua_gettop(L);
    for (lua_Integer i = 1; i <= (lua_Integer)lua_rawlen(L, list); ++i) {
        lua_rawgeti(L, list, i);
        if (!lua_istable(L, -1))
            field_raise(L, "workloads", "workload %d is not a table", (int)i);
        read_workload(L, lua_gettop(L), c);
        lua_pop(L, 1);
    }
    if (c->n_workloads == 0)
        field_raise(L, "workloads", "workloads is an empty list");
    lua_pop(L, 1);
}

// ---------------------------------------------------------------- the rest

static void read_strategy(lua_State *L, tune_config *c)
{
    lua_getfield(L, ROOT, "strategy");
    bool is_function = lua_isfunction(L, -1);
    lua_pop(L, 1);
    if (is_function) {
        c->def.strategy = strategy_lua.name;
        c->def.strategy_lua = text_chars(&c->text);
        return;
    }
    c->def.strategy = field_string(L, ROOT, "strategy", c->def.strategy);
    if (!strategy_find(c->def.strategy))
        field_raise(L, "strategy", "there is no strategy '%s'; a function may also be given",
                    c->def.strategy);
}

// The strings of a list, one after the other.
static uint32_t read_list(lua_State *L, const char *name, const char **items, uint32_t most)
{
    if (!field_push(L, ROOT, name, LUA_TTABLE))
        return 0;
    uint32_t n = (uint32_t)lua_rawlen(L, -1);
    if (n == 0 || n > most)
        field_raise(L, name, "%s is a list of 1 to %d strings", name, (int)most);
    for (uint32_t i = 0; i < n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        if (lua_type(L, -1) != LUA_TSTRING)
            field_raise(L, name, "%s is a list of strings", name);
        items[i] = lua_tostring(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return n;
}

static void read_modes(lua_State *L, tune_config *c)
{
    const char *names[CONFIG_MODES];
    c->def.n_modes = read_list(L, "modes", names, CONFIG_MODES);
    for (uint32_t i = 0; i < c->def.n_modes; ++i)
        if (!mode_from_name(names[i], &c->modes[i]))
            field_raise(L, "modes", "there is no mode '%s'", names[i]);
}

// level = "sat6", or a list of levels that accuracy chooses from.
static void read_levels(lua_State *L, tune_config *c)
{
    const char *names[DUET_LEVELS];
    lua_getfield(L, ROOT, "level");
    bool is_list = lua_istable(L, -1);
    c->def.n_levels = !lua_isnil(L, -1);
    lua_pop(L, 1);
    if (!is_list) {
        accuracy_read_level(L, ROOT, &c->levels[0]);
        return;
    }
    c->def.n_levels = read_list(L, "level", names, DUET_LEVELS);
    for (uint32_t i = 0; i < c->def.n_levels; ++i)
        if (!duet_level_from_name(names[i], &c->levels[i]))
            field_raise(L, "level", "there is no level '%s'", names[i]);
}

static uint32_t read_count(lua_State *L, int table, const char *name, int64_t most)
{
    int64_t count = field_integer(L, table, name, 0);
    if (count < 0 || count > most)
        field_raise(L, name, "%s is a number from 0 to %d", name, (int)most);
    return (uint32_t)count;
}

static void read_budget(lua_State *L, tune_config *c)
{
    static const char *const names[] = {"seconds", "trials", NULL};
    if (!field_push(L, ROOT, "budget", LUA_TTABLE))
        return;
    int budget = lua_gettop(L);
    field_only(L, budget, "budget", names);
    c->def.budget_seconds = field_number(L, budget, "seconds", 0);
    if (c->def.budget_seconds < 0)
        field_raise(L, "seconds", "seconds is a time above 0");
    c->def.budget_trials = read_count(L, budget, "trials", INT32_MAX);
    lua_pop(L, 1);
}

// root, config -> the list that keeps strings
static int read_config(lua_State *L)
{
    static const char *const names[] = {
        "workloads", "pair", "strategy",  "variants", "search",   "modes", "budget",
        "repeats",   "seed", "objective", "level",    "accuracy", NULL};
    tune_config *c = lua_touserdata(L, CONFIG);
    lua_newtable(L);
    if (!lua_istable(L, ROOT))
        return field_raise(L, NULL, "a tune file returns a table, not %s", luaL_typename(L, ROOT));
    field_only(L, ROOT, "a tune file", names);
    c->def.objective = field_string(L, ROOT, "objective", c->def.objective);
    if (strcmp(c->def.objective, "time") != 0 && strcmp(c->def.objective, "energy") != 0)
        field_raise(L, "objective", "there is no objective '%s'; expected 'time' or 'energy'",
                    c->def.objective);
    read_workloads(L, c);
    read_strategy(L, c);
    read_modes(L, c);
    read_budget(L, c);
    read_levels(L, c);
    c->def.has_accuracy = accuracy_read(L, ROOT, &c->def.accuracy);
    if (c->def.n_levels > 1 && !c->def.has_accuracy)
        field_raise(L, "level", "several levels need an accuracy that one is chosen by");
    c->def.n_variants = read_list(L, "variants", c->variants, CONFIG_VARIANTS);
    c->def.search = field_string(L, ROOT, "search", NULL);
    c->pair = field_string(L, ROOT, "pair", NULL);
    c->def.repeats = read_count(L, ROOT, "repeats", 32);
    c->def.seed = read_count(L, ROOT, "seed", INT32_MAX);
    lua_settop(L, KEPT);
    return 1;
}

void tune_config_begin(tune_config *c)
{
    *c = (tune_config){.def = duet_default_tune_def()};
    c->def.variants = c->variants;
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
