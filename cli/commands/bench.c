// SPDX-License-Identifier: MIT
// duet bench: measures the standard set of scenes and plans, and compares with
// earlier results. Every plan must find the same pairs of a scene.
#include "base/error.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/costs.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/report/bench_results.h"
#include "cli/report/level_costs_report.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "tuner/trial_log.h"
#include "tuner/tuning.h"

#include <stdio.h>
#include <string.h>

typedef struct arguments {
    const char *pair;
    const char *scene;
    const char *task;
    scene_options size; // the task's
    const char *out;
    const char *against;
    uint64_t repeat;
    bool quick;
    bool json;
} arguments;

static const option options[] = {
    PAIR_OPTION_ROW(pair),
    OPTION_TEXT("scene", scene, "NAME",
                "measure this scene only: paper, paper2d, clustered, mixed, planes, falling"),
    OPTION_INPUT("task", task, "FILE", "measure a kernel of your own instead: a task file"),
    OPTION_COUNT("objects", size.n, "N", "the task's size", 0, DUET_MOST_OBJECTS),
    OPTION_OUTPUT("output", out, "FILE.json", "write the results, with all samples"),
    OPTION_INPUT("against", against, "OLD.json", "compare with results written by --output"),
    OPTION_COUNT("repeat", repeat, "K", "steps of each plan, after one to warm up (9)", 1,
                 BENCH_SAMPLES_MOST),
    OPTION_FLAG("quick", quick, "use small scenes, to see in seconds that all works"),
    OPTION_FLAG("json", json, "print one JSON object, as --output writes it"),
    {0},
};

static const option_rule rules[] = {
    {"objects", OPTION_NEEDS, "task"},
    {"scene quick", OPTION_EXCLUDES, "task"},
    {0},
};

static const command_line line = {
    .name = "bench",
    .about = "Measures a standard set: each device alone, shares in between, the modes, the\n"
             "kernels and the levels of accuracy on five scenes, and what each effect costs\n"
             "on a sixth. --against says what became faster or slower; the exit status is 1\n"
             "if something surely became slower.",
    .options = options,
    .rules = rules,
};

// ---------------------------------------------------------------- the standard set

// Says what is measured of a scene.
typedef enum bench_measures { BENCH_PLANS, BENCH_PLANS_AND_LEVELS, BENCH_EFFECTS } bench_measures;

typedef struct bench_scene {
    const char *name; // one of those that come with Duet
    const char *n;    // objects, as a scene's setting
    const char *quick_n;
    const char *world; // edge of the world; NULL: the scene's own
    const char *quick_world;
    bench_measures measures;
    bool mixed; // sizes: plans that need one size of cells are left out
} bench_scene;

static const bench_scene bench_scenes[] = {
    // The density is that of a million objects in the paper's world.
    {.name = "paper", "250000", "3000", "126", "29", .measures = BENCH_PLANS_AND_LEVELS},
    {.name = "paper2d", "250000", "3000", "1000", "110"},
    {.name = "clustered", "100000", "3000"},
    {.name = "mixed", "100000", "3000", .mixed = true},
    {.name = "planes", "100000", "3000"},
    {.name = "falling", "20000", "200", .measures = BENCH_EFFECTS},
    {0},
};

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 4, DUET_SHARE_ONE / 2, DUET_SHARE_ONE * 3 / 4,
                                  DUET_SHARE_ONE};
static const duet_mode modes[] = {DUET_MODE_SHARED, DUET_MODE_SLAB};
static const struct {
    const char *variant;
    bool one_size; // takes cells of one size
} variants[] = {{"auto", false}, {"simd", false}, {"auto sort=radix", false}, {"paper", true}};

typedef struct plan_list {
    duet_plan *plans;
    uint32_t n;
} plan_list;

// Adds a plan unless it is there: the pair's own kernels are among the others.
static void add(plan_list *list, const duet_plan *plan)
{
    for (uint32_t i = 0; i < list->n; ++i) {
        if (trial_log_same_plan(&list->plans[i], plan))
            return;
    }
    list->plans[list->n++] = *plan;
}

enum { BENCH_PLANS_MOST = 16 };

// The plans for a scene on this pair: each device alone, shares in between, the
// other modes and the other kernels, each at half; of one device its kernels. Returns
// how many.
static uint32_t bench_plans(const bench_scene *scene, const duet_device_pair *pair,
                            duet_plan plans[BENCH_PLANS_MOST])
{
    plan_list list = {plans, 0};
    duet_plan plan = duet_default_plan(pair);
    plan.mode = DUET_MODE_OWN;
    const bool one = duet_device_pair_is_one(pair);
    for (size_t i = 0; i < (one ? 1 : sizeof shares / sizeof *shares); ++i) {
        plan.share = shares[i];
        add(&list, &plan);
    }
    plan.share = one ? 0 : DUET_SHARE_ONE / 2;
    for (size_t i = 0; i < sizeof variants / sizeof *variants; ++i) {
        plan_set_variants(&plan, variants[i].variant);
        if (!(variants[i].one_size && scene->mixed))
            add(&list, &plan);
    }
    plan_set_variants(&plan, "auto");
    for (size_t i = 0; i < sizeof modes / sizeof *modes && !scene->mixed && !one; ++i) {
        plan.mode = modes[i];
        add(&list, &plan);
    }
    return list.n;
}

// ---------------------------------------------------------------- measuring

// Everything that a run holds, given back in one place.
typedef struct bench {
    const arguments *args;
    duet_device_pair *pair;
    cJSON *results;
    cJSON *before; // NULL: nothing to compare with
    bool tells;    // tables on stdout
    bool told;     // one of them is there
    uint32_t failed;
    progress shown;
    uint64_t done; // cases
} bench;

static duet_scene *load_scene(const bench_scene *s, bool quick, duet_error *err)
{
    const duet_setting settings[] = {{"n", quick ? s->quick_n : s->n},
                                     {"world", quick ? s->quick_world : s->world}};
    return duet_scene_load(s->name, settings, s->world ? 2 : 1, err);
}

// A plan that fails is a case that says so, and a line on stderr; other plans
// are measured all the same.
static bool keep_failure(bench *b, const bench_subject *subject, const duet_plan *plan,
                         const duet_error *failure, duet_error *err)
{
    if (failure->status == DUET_STATUS_INTERRUPTED ||
        !bench_add(b->results, subject, plan, NULL, failure))
        return error_copy(err, failure);
    ++b->failed;
    say_failed(failure);
    return true;
}

// Keeps what was measured by the plan, which it frees, or why that failed (NULL: it did not).
static bool keep_case(bench *b, const bench_subject *subject, const duet_plan *plan, timed *t,
                      const duet_error *failure, duet_error *err)
{
    bool ok = !failure || keep_failure(b, subject, plan, failure, err);
    if (!failure)
        bench_add(b->results, subject, plan, t, NULL);
    timed_free(t);
    progress_show(&b->shown, ++b->done);
    return ok && interrupt_check(err);
}

static bool check_pairs(const timed *t, uint64_t *hash, const duet_scene_info *info,
                        const duet_plan *plan, duet_error *err)
{
    if (*hash == 0)
        *hash = t->hash;
    return t->hash == *hash ||
           error_set(err, DUET_STATUS_WRONG_RESULT,
                     "%s by '%s', mode %s, share %.2f: other pairs than by the first plan",
                     info->name, plan->variant_a, duet_mode_name(plan->mode),
                     (double)plan->share / DUET_SHARE_ONE);
}

static bool measure(bench *b, duet_world *world, const duet_scene *scene, const duet_plan *plan,
                    uint64_t *hash, duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    const bench_subject subject = {info->name, info->dims, info->n};
    duet_error failure = {0};
    timed t = {0};
    bool ok = duet_world_set_plan(world, plan, &failure) &&
              timed_run(&t, world, scene, (uint32_t)b->args->repeat, TIMED_INPUT_HOST, &failure) &&
              check_pairs(&t, hash, info, plan, &failure);
    return keep_case(b, &subject, plan, &t, ok ? NULL : &failure, err);
}

static bool measure_plans(bench *b, const bench_scene *which, const duet_scene *scene,
                          duet_error *err)
{
    uint64_t hash = 0;
    duet_plan plans[BENCH_PLANS_MOST];
    uint32_t n = bench_plans(which, b->pair, plans);
    duet_world_def def = duet_scene_world_def(scene, b->pair);
    duet_world *world = duet_world_create(&def, err);
    bool ok = world != NULL;
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = measure(b, world, scene, &plans[i], &hash, err);
    duet_world_destroy(world);
    return ok;
}

// An empty line between two tables.
static void begin_block(bench *b)
{
    if (b->told)
        putchar('\n');
    b->told = true;
}

// Results of the other plans are printed even if one failed.
static bool compare_plans(bench *b, const bench_scene *which, const duet_scene *scene,
                          duet_error *err)
{
    bool ok = measure_plans(b, which, scene, err);
    bench_compare(b->results, b->before);
    progress_hide(&b->shown);
    if (b->tells) {
        begin_block(b);
        ok = bench_tell(b->results, duet_scene_get_info(scene)->name, b->before, err) && ok;
    }
    return ok;
}

static bool measure_levels(bench *b, const duet_scene *scene, duet_error *err)
{
    level_costs p;
    uint32_t rounds =
        b->args->repeat < LEVEL_COSTS_ROUNDS ? (uint32_t)b->args->repeat : LEVEL_COSTS_ROUNDS;
    if (!level_costs_show(&p, b->pair, scene, rounds, err))
        return false;
    ++b->done;
    progress_hide(&b->shown);
    cJSON *o = level_costs_report_json(&p, duet_scene_get_info(scene), b->pair);
    cJSON_AddItemToArray(cJSON_GetObjectItem(b->results, "accuracy"), o);
    if (!b->tells)
        return true;
    begin_block(b);
    return rendering_print("cli/report/levels.lua", o, err);
}

static bool measure_effects(bench *b, const duet_scene *scene, duet_error *err)
{
    enum { STEPS = 20, QUICK_STEPS = 3 };
    costs c;
    const duet_scene_info *info = duet_scene_get_info(scene);
    progress_show(&b->shown, b->done++);
    duet_motion_def def = duet_scene_motion_def(scene, b->pair);
    if (!costs_measure(&c, &def, scene, b->args->quick ? QUICK_STEPS : STEPS, err))
        return false;
    cJSON *o = costs_report_json(&c, info, b->pair);
    cJSON_AddItemToArray(cJSON_GetObjectItem(b->results, "effects"), o);
    progress_hide(&b->shown);
    if (!b->tells)
        return true;
    begin_block(b);
    printf("%s, %s that move\n", info->name, say_things(info->n, "object", "objects").chars);
    return rendering_print("cli/report/explain.lua", o, err);
}

static bool measure_scene(bench *b, const bench_scene *which, duet_error *err)
{
    duet_scene *scene = load_scene(which, b->args->quick, err);
    bool ok = scene;
    if (which->measures == BENCH_EFFECTS)
        ok = ok && measure_effects(b, scene, err);
    else
        ok = ok && compare_plans(b, which, scene, err);
    if (which->measures == BENCH_PLANS_AND_LEVELS)
        ok = ok && measure_levels(b, scene, err);
    duet_scene_destroy(scene);
    return ok;
}

// A run that was stopped writes what was measured until then.
static bool finish(bench *b, duet_error *err)
{
    bool ok = true;
    if (b->args->out) {
        text chars = {0};
        ok = json_write(b->results, &chars, err) && say_to_file(&chars, b->args->out, err);
        text_free(&chars);
    }
    if (b->args->json) {
        ok = say_json(b->results, err) && ok;
        b->results = NULL;
    } else if (b->tells && b->before) {
        begin_block(b);
        ok = bench_tell(b->results, NULL, b->before, err) && ok;
    }
    return ok;
}

static bool is_asked_for(const bench *b, const bench_scene *s)
{
    return !b->args->scene || strcmp(b->args->scene, s->name) == 0;
}

// Plans, levels of accuracy and effects, each of a scene.
static uint64_t count_cases(const bench *b)
{
    uint64_t n = 0;
    duet_plan plans[BENCH_PLANS_MOST];
    for (const bench_scene *s = bench_scenes; s->name; ++s)
        if (is_asked_for(b, s))
            n += s->measures == BENCH_EFFECTS
                     ? 1
                     : bench_plans(s, b->pair, plans) + (s->measures == BENCH_PLANS_AND_LEVELS);
    return n;
}

static bool measure_scenes(bench *b, duet_error *err)
{
    bool ok = true;
    bool any = false;
    b->shown = progress_begin("case", count_cases(b));
    for (const bench_scene *s = bench_scenes; ok && s->name; ++s) {
        if (!is_asked_for(b, s))
            continue;
        any = true;
        ok = measure_scene(b, s, err);
    }
    progress_end(&b->shown);
    return ok &&
           (any ||
            bad_argument(
                err,
                "--scene '%s': the set has paper, paper2d, clustered, mixed, planes and falling",
                b->args->scene));
}

static uint32_t count_results(const bench *b)
{
    static const char *const lists[] = {"cases", "accuracy", "effects"};
    int n = 0;
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
        n += cJSON_GetArraySize(cJSON_GetObjectItem(b->results, lists[i]));
    return (uint32_t)n;
}

// The last line of a run that was stopped says what its file holds.
static void tell_stopped(const bench *b, uint32_t n, duet_error *err)
{
    if (err->status != DUET_STATUS_INTERRUPTED || !b->args->out || options_is_stdout(b->args->out))
        return;
    *err = (duet_error){0};
    error_set(err, DUET_STATUS_INTERRUPTED, "stopped; %s holds %s", b->args->out,
              say_things(n, "case", "cases").chars);
}

// ---------------------------------------------------------------- a task

static uint32_t task_plans(const duet_device_pair *pair, duet_plan plans[BENCH_PLANS_MOST])
{
    plan_list list = {plans, 0};
    duet_plan plan = {.mode = DUET_MODE_OWN};
    plan_set_variants(&plan, "auto");
    for (size_t i = 0; i < (duet_device_pair_is_one(pair) ? 1 : sizeof shares / sizeof *shares);
         ++i) {
        plan.share = shares[i];
        add(&list, &plan);
    }
    return list.n;
}

static bool measure_launches(bench *b, task_launcher *l, const bench_subject *subject,
                             const duet_plan *plan, duet_error *err)
{
    duet_error failure = {0};
    timed t = {0};
    bool ok = timed_task_run(&t, l, b->pair, plan, (uint32_t)b->args->repeat, &failure);
    return keep_case(b, subject, plan, &t, ok ? NULL : &failure, err);
}

static bool measure_shares(bench *b, const task *t, task_launcher *l, duet_error *err)
{
    duet_plan plans[BENCH_PLANS_MOST];
    const bench_subject subject = {.name = t->name, .objects = t->items};
    uint32_t n = task_plans(b->pair, plans);
    bool ok = true;
    b->shown = progress_begin("case", n);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = measure_launches(b, l, &subject, &plans[i], err);
    progress_end(&b->shown);
    bench_compare(b->results, b->before);
    if (b->tells) {
        begin_block(b);
        ok = bench_tell(b->results, t->name, b->before, err) && ok;
    }
    return ok;
}

static bool measure_task(bench *b, duet_error *err)
{
    task *t = inputs_load_task(b->args->task, &b->args->size, err);
    task_launcher *l = t ? task_launcher_open(t, b->pair, err) : NULL;
    bool ok = l && measure_shares(b, t, l, err);
    task_launcher_close(l);
    task_destroy(t);
    return ok;
}

// ---------------------------------------------------------------- all

static bool measure_all(bench *b, duet_error *err)
{
    b->results = bench_begin(b->pair, b->args->quick);
    bool ok = b->args->task ? measure_task(b, err) : measure_scenes(b, err);
    char slower[BENCH_NAME];
    uint32_t n_slower = 0;
    uint32_t n_results = count_results(b);
    bool any_slower = bench_first_slower(b->results, slower, &n_slower);
    bool written = finish(b, ok ? err : NULL);
    if (written && !ok)
        tell_stopped(b, n_results, err);
    ok = written && ok;
    if (ok && b->failed > 0)
        ok = error_set(err, DUET_STATUS_DEVICE_FAILED, "%u plan%s failed", b->failed,
                       b->failed == 1 ? "" : "s");
    if (ok && any_slower)
        ok =
            error_set(err, DUET_STATUS_WRONG_RESULT, "%u of the cases became slower for sure: %s%s",
                      n_slower, slower, n_slower > 1 ? ", and others" : "");
    return ok;
}

static bool run(void *given, char **operands, duet_error *err)
{
    (void)operands;
    const arguments *args = given;
    bench b = {.args = args, .tells = !args->json && !options_is_stdout(args->out)};
    b.before = args->against ? bench_read(args->against, err) : NULL;
    bool ok = b.before || !args->against;
    b.pair = ok ? inputs_open_pair(args->pair, err) : NULL;
    ok = b.pair && measure_all(&b, err);
    cJSON_Delete(b.results);
    cJSON_Delete(b.before);
    duet_device_pair_destroy(b.pair);
    return ok;
}

SUBCOMMAND(bench, .repeat = 9, .size = SCENE_OPTIONS_DEFAULT)
