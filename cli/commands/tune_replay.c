// SPDX-License-Identifier: MIT
// One tuning draws its launches by chance. So each strategy is replayed many times, and the run
// with the median loss is shown, whose figures belong together.
#include "cli/commands/tune.h"

#include "base/error.h"
#include "base/text_file.h"
#include "cli/commands/profiles.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "tuner/replay.h"
#include "tuner/strategy.h"

#include <stdlib.h>
#include <string.h>

enum { RUNS = 101 };

// ---------------------------------------------------------------- runs

static int by_loss(const void *a, const void *b)
{
    double x = ((const replay_outcome *)a)->loss, y = ((const replay_outcome *)b)->loss;
    return (x > y) - (x < y);
}

// Each run's gains, as [seconds, ms].
static void add_gains(cJSON *row, const replay_outcome *outcomes)
{
    cJSON *runs = cJSON_AddArrayToObject(row, "runs");
    for (uint32_t i = 0; i < RUNS; ++i) {
        cJSON *gains = cJSON_CreateArray();
        cJSON_AddItemToArray(runs, gains);
        for (uint32_t k = 0; k < outcomes[i].n_gains; ++k) {
            const replay_gain *g = &outcomes[i].gains[k];
            const double at[2] = {g->seconds, g->median_ns * 1e-6};
            cJSON_AddItemToArray(gains, cJSON_CreateDoubleArray(at, 2));
        }
    }
}

static cJSON *add_outcome(cJSON *rows, const char *name, const replay_outcome *o,
                          const replay_outcome *worst)
{
    cJSON *row = json_add_row(rows);
    json_add(row, STRING("strategy", name));
    json_add_plan(row, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                  o->plan.variant_a, o->plan.variant_b);
    json_add(row, NUMBER("ms", o->median_ns * 1e-6), NUMBER("loss", o->loss),
             NUMBER("worst_loss", worst->loss), STRING("verdict", o->verdict),
             NUMBER("search_launches", o->search_launches), NUMBER("launches", o->launches),
             NUMBER("seconds", o->seconds));
    return row;
}

static bool replay_strategy(replay *r, duet_tune_def def, script *own, cJSON *rows, duet_error *err)
{
    replay_outcome runs[RUNS];
    uint64_t seed = def.seed;
    for (uint32_t i = 0; i < RUNS; ++i) {
        def.seed = rng_stream(seed, i).state;
        if (!interrupt_check(err) || !replay_run(r, &def, own, &runs[i], err))
            return false;
    }
    qsort(runs, RUNS, sizeof *runs, by_loss);
    add_gains(add_outcome(rows, def.strategy, &runs[RUNS / 2], &runs[RUNS - 1]), runs);
    return true;
}

static uint64_t seed_of(const arguments *args)
{
    return args->scene.seed == UINT64_MAX ? 0 : args->scene.seed;
}

// The strategy that was asked for, or each that needs no script and fits the surface. Brute force
// takes what was recorded for the truth.
static bool replay_strategies(replay *r, const arguments *args, script *lua, cJSON *rows,
                              duet_error *err)
{
    const char *asked = lua ? strategy_lua.name : args->strategy;
    const strategy_choice choice = r->surface->joint ? STRATEGY_JOINT : STRATEGY_SHARE;
    duet_tune_def def = duet_default_tune_def();
    def.seed = seed_of(args);
    def.repeats = args->repeats ? (uint32_t)args->repeats : def.repeats;
    if ((def.strategy = asked))
        return replay_strategy(r, def, lua, rows, err);
    for (uint32_t i = 0; strategies[i]; ++i) {
        def.strategy = strategies[i]->name;
        if (strategies[i]->choice == choice && strategies[i] != &strategy_lua &&
            !replay_strategy(r, def, NULL, rows, err))
            return false;
    }
    return true;
}

// ---------------------------------------------------------------- surfaces

static cJSON *list_medians(const replay *r)
{
    cJSON *list = cJSON_CreateArray();
    for (uint32_t i = 0; i < r->n_points; ++i)
        cJSON_AddItemToArray(list, cJSON_CreateNumber(r->points[i].median_ns * 1e-6));
    return list;
}

static cJSON *describe(const replay *r)
{
    const profile_surface *s = r->surface;
    const duet_plan *best = &r->best->plan;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", s->scene),
             NUMBER("objects", (double)(*s->query ? s->boxes : s->n)));
    if (*s->query) {
        json_add(o, STRING("query", s->query), NUMBER("items", s->n));
    }
    json_add(o, STRING("level", s->level), STRING("a", s->a), STRING("b", s->b),
             NUMBER("plans", r->n_points), NUMBER("best_ms", r->best->median_ns * 1e-6));
    cJSON_AddItemToObject(o, "recorded_ms", list_medians(r));
    json_add_plan(o, best->share / (double)DUET_SHARE_ONE, duet_mode_name(best->mode),
                  s->joint ? best->variant_a : s->variant_a,
                  s->joint ? best->variant_b : s->variant_b);
    return o;
}

static bool replay_surface(store *s, const profile_surface *surface, const arguments *args,
                           script *lua, cJSON *workloads, duet_error *err)
{
    replay r;
    bool ok = replay_open(&r, s, surface, err);
    if (ok) {
        cJSON *o = describe(&r);
        cJSON_AddItemToArray(workloads, o);
        ok = replay_strategies(&r, args, lua, cJSON_AddArrayToObject(o, "strategies"), err);
    }
    replay_close(&r);
    return ok;
}

// A strategy that is asked for is replayed on the surfaces of its kind.
static bool fits(const profile_surface *surface, const arguments *args, script *lua)
{
    const char *asked = lua ? strategy_lua.name : args->strategy;
    const strategy *s = asked ? strategy_of(asked, lua) : NULL;
    return !s || (s->choice != STRATEGY_SHARE) == surface->joint;
}

static bool is_wanted(const profile_surface *surface, const char *scene, const number_list *numbers)
{
    bool listed = numbers->n == 0;
    for (uint32_t i = 0; i < numbers->n; ++i)
        listed |= (uint64_t)numbers->items[i] == surface->n;
    return listed && (!scene || strcmp(scene, surface->scene) == 0);
}

static bool fail_unwanted(const arguments *args, const profile_surface *surfaces, uint32_t n,
                          duet_error *err)
{
    text known = {0};
    if (n == 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "%s: no workload's shares were all measured; expected one that 'duet tune "
                         "SCENE --strategy grid' has stored",
                         args->replay);
    for (uint32_t i = 0; i < n; ++i)
        text_add(&known, "%s%s -n %llu", i ? ", " : "", surfaces[i].scene,
                 (unsigned long long)surfaces[i].n);
    bad_argument(err, "%s: does not have that workload; it has %s", args->replay,
                 text_chars(&known));
    text_free(&known);
    return false;
}

static bool fail_unfit(const arguments *args, duet_error *err)
{
    return error_set(err, DUET_STATUS_NOT_FOUND,
                     "%s: has no workload for that strategy; expected shares that '--strategy "
                     "grid' has stored, or kernels and shares that '--strategy brute' has",
                     args->replay);
}

static bool replay_store(store *s, const arguments *args, const char *scene,
                         const number_list *numbers, script *lua, cJSON *workloads, duet_error *err)
{
    profile_surface *surfaces;
    uint32_t n;
    bool ok = profile_surfaces_get(s, &surfaces, &n, err);
    bool wanted = false;
    for (uint32_t i = 0; ok && i < n; ++i) {
        if (!is_wanted(&surfaces[i], scene, numbers))
            continue;
        wanted = true;
        ok = !fits(&surfaces[i], args, lua) ||
             replay_surface(s, &surfaces[i], args, lua, workloads, err);
    }
    if (ok && cJSON_GetArraySize(workloads) == 0)
        ok = wanted ? fail_unfit(args, err) : fail_unwanted(args, surfaces, n, err);
    free(surfaces);
    return ok && store_check_read(s, err);
}

static bool open_script(const char *path, script **opened, duet_error *err)
{
    text chars = {0};
    *opened = NULL;
    if (!path)
        return true;
    if (text_read_lines(&chars, path, err))
        *opened = strategy_lua_open(path, text_chars(&chars), err);
    text_free(&chars);
    return *opened;
}

bool tune_replay(const arguments *args, const char *scene, const number_list *numbers,
                 duet_error *err)
{
    script *lua;
    if (!open_script(args->strategy_path, &lua, err))
        return false;
    cJSON *workloads = cJSON_CreateArray();
    store *s = profiles_open(args->replay, STORE_READ, err);
    bool ok = s && replay_store(s, args, scene, numbers, lua, workloads, err);
    store_close(s);
    script_close(lua);
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("seed", seed_of(args)), NUMBER("runs", RUNS));
    cJSON_AddItemToObject(o, "workloads", workloads);
    if (ok)
        return rendering_tell(o, args->json, "cli/report/replay.lua", err);
    cJSON_Delete(o);
    return false;
}
