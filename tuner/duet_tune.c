// SPDX-License-Identifier: MIT
#include "tuner/duet_tune.h"

#include "runtime/base/error.h"
#include "runtime/profiled.h"
#include "tuner/race.h"
#include "tuner/record.h"
#include "tuner/strategy.h"
#include "tuner/strategy_lua.h"

#include <string.h>

enum { COOKIE = 0x0d0e7003, REPEATS = 3, GROUP = 128 };

duet_tune_def duet_default_tune_def(void)
{
    return (duet_tune_def){
        .strategy = strategies[0]->name, .keep = true, .repeats = REPEATS, .cookie = COOKIE};
}

const char *duet_strategy(uint32_t i)
{
    return strategies[i] ? strategies[i]->name : NULL;
}

const char *duet_strategy_about(uint32_t i)
{
    return strategies[i] ? strategies[i]->about : NULL;
}

// ---------------------------------------------------------------- checks

static bool check_strategy(const char *name, duet_error *err)
{
    search s;
    bool ok = search_begin(&s, name, NULL, err);
    search_end(&s);
    return ok;
}

static bool check_def(const duet_tune_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_set(err, DUET_BAD_ARGUMENT,
                         "the tuning's def does not come from duet_default_tune_def");
    if (!def->pair || !def->scene || !def->strategy)
        return error_set(err, DUET_BAD_ARGUMENT,
                         "the tuning's def lacks a pair, scene or strategy");
    if (def->repeats > MEASURE_REPEATS)
        return error_set(err, DUET_BAD_ARGUMENT, "%u launches a trial; right would be at most %d",
                         def->repeats, MEASURE_REPEATS);
    if (def->n_variants > RACE_RIVALS)
        return error_set(err, DUET_BAD_ARGUMENT, "%u variants; right would be at most %d",
                         def->n_variants, RACE_RIVALS);
    for (uint32_t i = 0; i < def->n_variants; ++i) {
        variant v;
        if (!variant_parse(&v, def->variants[i], duet_device_pair_info(def->pair, 0), err))
            return false;
    }
    return check_strategy(def->strategy, err);
}

// ---------------------------------------------------------------- a tuning

// Everything a tuning holds, given back in one place.
typedef struct holdings {
    duet_tune_def def;
    duet_world *world;
    script *script;
    profiled profiled;
    record record; // without a store where nothing is kept
    tape state;
} holdings;

static void let_go(holdings *h)
{
    record_close(&h->record);
    tape_free(&h->state);
    script_close(h->script);
    duet_world_destroy(h->world);
}

static bool make_world(holdings *h, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(h->def.scene, h->def.pair);
    def.level = h->def.level;
    h->world = duet_world_create(&def, err);
    return h->world && duet_world_set_scene(h->world, h->def.scene, err);
}

static bool open_script(holdings *h, duet_error *err)
{
    if (!h->def.strategy_lua)
        return true;
    h->script = strategy_lua_open("strategy", h->def.strategy_lua, err);
    return h->script;
}

static bool open_store(holdings *h, duet_error *err)
{
    if (!profiled_world(h->world, &h->profiled, err))
        return false;
    h->profiled.workload.name = duet_scene_describe(h->def.scene)->name;
    profile_request request = profiled_request(&h->profiled);
    return !h->def.keep || record_open(&h->record, h->def.store, &request, err);
}

static bool prepare(holdings *h, const duet_tune_def *def, duet_error *err)
{
    h->def = *def;
    h->def.repeats = def->repeats ? def->repeats : REPEATS;
    return make_world(h, err) && open_script(h, err) && open_store(h, err);
}

static bool is_finished(const profile_found *found)
{
    return found->grade == PROFILE_EXACT;
}

static bool tell_known(const profile_found *found, duet_tune_outcome *outcome, duet_error *err)
{
    *outcome = (duet_tune_outcome){
        .gain = found->gain,
        .gain_low = found->gain_low,
        .gain_high = found->gain_high,
        .step_ms = found->median_ns * 1e-6,
        .known = true,
    };
    memcpy(outcome->verdict, found->verdict, sizeof outcome->verdict);
    if (!profiled_read_plan(&found->plan, &outcome->plan, err))
        return false;
    outcome->best = outcome->plan;
    return true;
}

// The pairs that every plan must find.
static bool find_right_hash(const duet_scene *scene, duet_level level, uint64_t *hash,
                            duet_error *err)
{
    duet_pair *pairs;
    uint64_t n;
    if (!duet_reference_at(scene, level, &pairs, &n, err))
        return false;
    *hash = duet_pairs_hash(pairs, n);
    duet_free(pairs);
    return true;
}

// The share of about one work-group.
static uint32_t least_share(uint32_t n)
{
    uint64_t share = n ? (uint64_t)GROUP * DUET_SHARE_ONE / n : 1;
    return share < 1 ? 1 : share > DUET_SHARE_ONE / 32 ? DUET_SHARE_ONE / 32 : (uint32_t)share;
}

static bool run(holdings *h, const profile_found *near, duet_tune_outcome *outcome, duet_error *err)
{
    uint64_t hash;
    const duet_scene_info *info = duet_scene_describe(h->def.scene);
    measure_world world = {.world = h->world, .shape = info->shape, .n = info->n};
    if (!find_right_hash(h->def.scene, h->def.level, &hash, err))
        return false;
    bool guessed = near->grade == PROFILE_INTERPOLATED || near->grade == PROFILE_TRANSFERRED ||
                   near->grade == PROFILE_OTHER_DRIVER || near->grade == PROFILE_STALE;
    tune_task task = {
        .def = &h->def,
        .machine = measure_world_machine(&world, hash),
        .plan = *duet_world_plan(h->world),
        .has_start = guessed,
        .start = near->plan.share,
        .script = h->script,
        .least_share = least_share(info->n),
    };
    if (h->record.store)
        task.recorder = record_recorder(&h->record);
    return tune_run(&task, &h->state, outcome, err);
}

// The session ends as the tuning did; an interrupted one can be resumed.
static bool run_recorded(holdings *h, const profile_found *near, duet_tune_outcome *outcome,
                         duet_error *err)
{
    bool resumed;
    duet_error why = {0};
    if (!record_begin(&h->record, &h->def, &h->state, &resumed, err))
        return false;
    bool ok = run(h, near, outcome, &why);
    outcome->resumed = resumed;
    const char *how = ok ? "complete" : why.status == DUET_INTERRUPTED ? "stopped" : "failed";
    ok = record_end(&h->record, how, outcome, ok ? err : NULL) && ok;
    if (why.status != DUET_OK && err && err->status == DUET_OK)
        *err = why;
    return ok;
}

bool duet_tune_run(const duet_tune_def *def, duet_tune_outcome *outcome, duet_error *err)
{
    holdings h = {0};
    profile_found found = {.grade = PROFILE_DEFAULT};
    *outcome = (duet_tune_outcome){0};
    bool ok = check_def(def, err) && prepare(&h, def, err);
    if (ok && h.record.store)
        ok = record_known(&h.record, &found, err);
    if (ok && is_finished(&found) && !def->fresh)
        ok = tell_known(&found, outcome, err);
    else if (ok && h.record.store)
        ok = run_recorded(&h, &found, outcome, err);
    else if (ok)
        ok = run(&h, &found, outcome, err);
    if (ok)
        outcome->objects = duet_scene_describe(def->scene)->n;
    let_go(&h);
    return ok;
}
