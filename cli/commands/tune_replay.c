// SPDX-License-Identifier: MIT
// One tuning draws its launches by chance. So each strategy is replayed many times, and the run
// with the median loss is shown, whose figures belong together.
#include "cli/commands/tune_replay.h"

#include "base/error.h"
#include "base/text_file.h"
#include "cli/commands/profiles.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "tuner/replay.h"
#include "tuner/strategy.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 101 };

// ---------------------------------------------------------------- runs

static int by_loss(const void *a, const void *b)
{
    double x = ((const replay_outcome *)a)->loss, y = ((const replay_outcome *)b)->loss;
    return (x > y) - (x < y);
}

static void add_outcome(cJSON *rows, const char *name, const replay_outcome *o,
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
}

static bool replay_strategy(replay *r, replay_def def, cJSON *rows, duet_error *err)
{
    replay_outcome runs[RUNS];
    uint64_t seed = def.seed;
    for (uint32_t i = 0; i < RUNS; ++i) {
        def.seed = rng_stream(seed, i).state;
        if (!interrupt_check(err) || !replay_run(r, &def, &runs[i], err))
            return false;
    }
    qsort(runs, RUNS, sizeof *runs, by_loss);
    add_outcome(rows, def.strategy, &runs[RUNS / 2], &runs[RUNS - 1]);
    return true;
}

// The strategy that was asked for, or each that needs no script.
static bool replay_strategies(replay *r, const replay_options *options, script *lua, cJSON *rows,
                              duet_error *err)
{
    const char *asked = lua ? strategy_lua.name : options->strategy;
    replay_def def = {.repeats = (uint32_t)options->repeats, .seed = options->seed};
    def.script = lua;
    if ((def.strategy = asked))
        return replay_strategy(r, def, rows, err);
    for (uint32_t i = 0; strategy_at(i); ++i) {
        def.strategy = strategy_at(i)->name;
        if (strategy_at(i) != &strategy_lua && !replay_strategy(r, def, rows, err))
            return false;
    }
    return true;
}

// ---------------------------------------------------------------- surfaces

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
    json_add_plan(o, best->share / (double)DUET_SHARE_ONE, duet_mode_name(best->mode), s->variant_a,
                  s->variant_b);
    return o;
}

static bool replay_surface(store *s, const profile_surface *surface, const replay_options *options,
                           script *lua, cJSON *workloads, duet_error *err)
{
    replay r;
    bool ok = replay_open(&r, s, surface, err);
    if (ok) {
        cJSON *o = describe(&r);
        cJSON_AddItemToArray(workloads, o);
        ok = replay_strategies(&r, options, lua, cJSON_AddArrayToObject(o, "strategies"), err);
    }
    replay_close(&r);
    return ok;
}

static bool is_wanted(const profile_surface *surface, const replay_options *options)
{
    bool listed = options->n_numbers == 0;
    for (uint32_t i = 0; i < options->n_numbers; ++i)
        listed |= (uint64_t)options->numbers[i] == surface->n;
    return listed && (!options->scene || strcmp(options->scene, surface->scene) == 0);
}

static bool fail_unwanted(const replay_options *options, const profile_surface *surfaces,
                          uint32_t n, duet_error *err)
{
    text known = {0};
    if (n == 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "%s: no workload's shares were all measured; expected one that 'duet tune "
                         "SCENE --strategy grid' has stored",
                         options->store);
    for (uint32_t i = 0; i < n; ++i)
        text_add(&known, "%s%s -n %llu", i ? ", " : "", surfaces[i].scene,
                 (unsigned long long)surfaces[i].n);
    error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: does not have that workload; it has %s",
              options->store, text_chars(&known));
    text_free(&known);
    return false;
}

static bool replay_store(store *s, const replay_options *options, script *lua, cJSON *workloads,
                         duet_error *err)
{
    profile_surface *surfaces;
    uint32_t n;
    bool ok = profile_surfaces_get(s, &surfaces, &n, err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = !is_wanted(&surfaces[i], options) ||
             replay_surface(s, &surfaces[i], options, lua, workloads, err);
    ok = ok && (cJSON_GetArraySize(workloads) > 0 || fail_unwanted(options, surfaces, n, err));
    free(surfaces);
    return ok && store_check_read(s, err);
}

// ---------------------------------------------------------------- what is printed

static table_text plan_text(const cJSON *row)
{
    table_text t;
    double share = json_number(row, "share");
    if (share > 0 && share < 1)
        snprintf(t.chars, sizeof t.chars, "A %.2f %% %s", 100 * share, json_string(row, "mode"));
    else
        snprintf(t.chars, sizeof t.chars, "%s alone", share > 0 ? "A" : "B");
    return t;
}

static void print_strategies(const cJSON *workload)
{
    table t = table_begin("llrrrrrr");
    const cJSON *row;
    table_words(&t, "strategy", "plan", "ms", "loss %", "worst", "search", "launches", "seconds",
                NULL);
    cJSON_ArrayForEach(row, json_list(workload, "strategies"))
    {
        table_words(&t, json_string(row, "strategy"), plan_text(row).chars, NULL);
        table_cell(&t, "%.3f", json_number(row, "ms"));
        table_cell(&t, "%.1f", 100 * json_number(row, "loss"));
        table_cell(&t, "%.1f", 100 * json_number(row, "worst_loss"));
        table_cell(&t, "%.0f", json_number(row, "search_launches"));
        table_cell(&t, "%.0f", json_number(row, "launches"));
        table_cell(&t, "%.2f", json_number(row, "seconds"));
    }
    table_print(&t, stdout);
}

static void print_workload(const cJSON *o)
{
    const char *query = json_string(o, "query");
    double objects = json_number(o, "objects");
    bool is_task = *query && objects == 0;
    printf("%s, %s%s%s", say_name(json_string(o, "scene")).chars,
           table_count((uint64_t)(is_task ? json_number(o, "items") : objects)).chars,
           is_task ? ", " : "", is_task ? say_name(query).chars : "");
    if (*query && !is_task)
        printf(": %s %s", table_count((uint64_t)json_number(o, "items")).chars,
               say_name(query).chars);
    printf("\nA: %s\nB: %s\n", say_name(json_string(o, "a")).chars,
           say_name(json_string(o, "b")).chars);
    printf("best of %.0f recorded plans: %s, %.3f ms\n", json_number(o, "plans"),
           plan_text(o).chars, json_number(o, "best_ms"));
    print_strategies(o);
    printf("\n");
}

static void print_workloads(const cJSON *workloads)
{
    const cJSON *o;
    cJSON_ArrayForEach(o, workloads) print_workload(o);
    printf("Each strategy was replayed %d times; its row is the run with the median loss.\n"
           "loss: by how much the plan takes longer than the best recorded one; worst: in\n"
           "the worst run. search: launches until the shares were searched; launches and\n"
           "seconds: with the races after it, and without compiling kernels.\n",
           RUNS);
}

static bool print(cJSON *workloads, const replay_options *options, duet_error *err)
{
    if (!options->json) {
        print_workloads(workloads);
        cJSON_Delete(workloads);
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("seed", options->seed), NUMBER("runs", RUNS));
    cJSON_AddItemToObject(o, "workloads", workloads);
    return say_json(o, err);
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

bool tune_replay(const replay_options *options, duet_error *err)
{
    script *lua;
    if (!open_script(options->strategy_path, &lua, err))
        return false;
    cJSON *workloads = cJSON_CreateArray();
    store *s = profiles_open(options->store, STORE_READ, err);
    bool ok = s && replay_store(s, options, lua, workloads, err);
    store_close(s);
    script_close(lua);
    if (ok)
        return print(workloads, options, err);
    cJSON_Delete(workloads);
    return false;
}
