// SPDX-License-Identifier: MIT
// device_pair:tune: finds how the two share a scene's work best.
#include "lua/tune.h"

#include "lua/policy.h"
#include "runtime/broadphase/variant.h"

#include <string.h>

// false: no store; true: what another strategy than the default one finds, too.
static void read_keep(lua_State *L, const field *f, void *at)
{
    if (!lua_isboolean(L, -1))
        field_refuse(L, f, "true or false");
    *(duet_keep *)at = lua_toboolean(L, -1) ? DUET_KEEP_ALWAYS : DUET_KEEP_NOTHING;
}

static const field_type field_keep = {.read = read_keep};

// A script's form of the def; the rest of the C def follows from it.
typedef struct tune_def {
    duet_tune_def def;
    field_name_list variants;
    field_enum_list modes, levels;
    bool watch; // the function stays in the def's table and is called from there
} tune_def;

static void read_accuracy(lua_State *L, const field *f, void *at)
{
    duet_tune_def *def = at;
    field_accuracy.read(L, f, &def->accuracy);
    def->has_accuracy = true;
}

static const field def_fields[] = {
    FIELDS_IN(tune_def, def., store),
    FIELD_IN(field_keep, tune_def, def., keep),
    FIELDS_IN(tune_def, def., ordered, fresh, strategy, strategy_lua, strategy_name, objective,
              search, query, items, steps),
    FIELDS(tune_def, variants),
    FIELD_ENUMS(tune_def, modes, mode_to_search_name),
    FIELDS_IN(tune_def, def., budget_seconds, budget_trials, wait_seconds, repeats, seed, script),
    FIELD_ENUMS_AT("level", tune_def, levels, level_name),
    FIELD_AT("accuracy", (const field_type){.read = read_accuracy}, tune_def, def),
    FIELD(field_function, tune_def, watch),
    {0},
};

static const field terms_fields[] = {
    FIELDS(duet_tune_terms, t1, cpu1, cpu2, gpu1, gpu2, gpu3, bus1, bus2, bus3, imbalance, joules),
    {0},
};

static const field_type field_terms = {.push = field_push_struct, .fields = terms_fields};

// A's and B's.
static void push_kernels(lua_State *L, const field *f, const void *at)
{
    (void)f;
    field_push_list(L,
                    FIELD_LIST(duet_kernel_search, configs, tried, launches, gain, gain_low,
                               gain_high, verdict),
                    at, 2, sizeof(duet_kernel_search));
}

static const field_type field_kernels = {.push = push_kernels};

static const field outcome_fields[] = {
    FIELD(field_plan, duet_tune_outcome, plan),
    FIELD(field_plan, duet_tune_outcome, best),
    FIELDS(duet_tune_outcome, objects),
    FIELD_ENUM(duet_tune_outcome, level, level_name),
    FIELD(field_accuracy, duet_tune_outcome, accuracy),
    FIELDS(duet_tune_outcome, true_pairs, gain, gain_low, gain_high, verdict, rounds, watched,
           disturbed, step_ms, step_low_ms, step_high_ms, single_ms, single_joules, whole_ms,
           whole_gain),
    FIELDS(duet_tune_outcome, whole_gain_low, whole_gain_high),
    FIELD(field_terms, duet_tune_outcome, terms),
    FIELD(field_kernels, duet_tune_outcome, kernels),
    FIELDS(duet_tune_outcome, plans, plans_tried, trials, launches, seconds, known, resumed, uid,
           unused),
    {0},
};

// ---------------------------------------------------------------- watching

typedef struct watcher {
    lua_State *lua;
    int function; // its index on the stack
    bool failed;  // its error is on top of the stack
} watcher;

// function, progress -> what it says
static int call_watch(lua_State *L)
{
    const duet_tune_progress *progress = lua_touserdata(L, 2);
    lua_pushvalue(L, 1);
    field_push_table(L,
                     FIELD_LIST(duet_tune_progress, stage, ms, trials, most_trials, launches,
                                seconds, remembered, expected_seconds, waiting),
                     progress);
    plan_push(L, progress->plan);
    lua_setfield(L, -2, "plan");
    lua_call(L, 1, 1);
    return 1;
}

// An error in the function stops the tuning, and is raised once that is over.
static bool watch(void *context, const duet_tune_progress *progress)
{
    watcher *w = context;
    lua_pushcfunction(w->lua, call_watch);
    lua_pushvalue(w->lua, w->function);
    lua_pushlightuserdata(w->lua, (void *)progress);
    w->failed = lua_pcall(w->lua, 2, 1, 0) != LUA_OK;
    if (w->failed)
        return false;
    bool stop = lua_isboolean(w->lua, -1) && !lua_toboolean(w->lua, -1);
    lua_pop(w->lua, 1);
    return !stop;
}

// ---------------------------------------------------------------- tuning

uint32_t tune_take_modes(const field_enum_list *list, duet_mode modes[FIELD_NAMES])
{
    for (uint32_t i = 0; i < list->n; ++i)
        modes[i] = (duet_mode)list->values[i];
    return list->n;
}

static void check_policy(lua_State *L, const duet_tune_def *def)
{
    if (def->keep != DUET_KEEP_NOTHING)
        policy_check_trusted(L, "keeping a profile (or else keep = false)");
    else if (def->store)
        policy_check_read(L, def->store);
}

// device_pair:tune(scene or task file, def)
static int device_pair_tune(lua_State *L)
{
    duet_error err = {0};
    duet_tune_outcome outcome = {0};
    duet_mode modes[FIELD_NAMES];
    duet_level levels[FIELD_NAMES];
    tune_def t = {.def = duet_default_tune_def()};
    t.def.pair = device_pair_check(L);
    t.def.task = task_file_test(L, 2);
    t.def.scene = t.def.task ? NULL : scene_check(L, 2);
    lua_settop(L, 3);
    field_read(L, 3, "a tuning", def_fields, &t);
    check_policy(L, &t.def);
    t.def.variants = t.variants.names;
    t.def.n_variants = t.variants.n;
    t.def.n_modes = tune_take_modes(&t.modes, modes);
    t.def.modes = modes;
    for (t.def.n_levels = 0; t.def.n_levels < t.levels.n; ++t.def.n_levels)
        levels[t.def.n_levels] = (duet_level)t.levels.values[t.def.n_levels];
    t.def.levels = levels;
    watcher w = {L, 4, false};
    if (t.watch) {
        lua_pushliteral(L, "watch");
        lua_rawget(L, 3);
        t.def.watch = watch;
        t.def.watch_context = &w;
    }
    luaL_checkstack(L, 4, "no space for a watcher");
    bool ok = duet_tune_run(&t.def, &outcome, &err);
    if (w.failed)
        return lua_error(L);
    if (!ok)
        return class_push_failure(L, &err);
    field_push_table(L, outcome_fields, &outcome);
    return 1;
}

// { name = ..., about = ... } of each strategy, the default first.
static int list_strategies(lua_State *L)
{
    lua_newtable(L);
    for (uint32_t i = 0; duet_strategy_get_name(i); ++i) {
        lua_createtable(L, 0, 2);
        lua_pushstring(L, duet_strategy_get_name(i));
        lua_setfield(L, -2, "name");
        lua_pushstring(L, duet_strategy_get_summary(i));
        lua_setfield(L, -2, "about");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

const lua_noun tune_noun = {
    {NULL},
    (const lua_method[]){{"duet.strategies", list_strategies, 0}, METHODS(device_pair, tune), {0}}};
