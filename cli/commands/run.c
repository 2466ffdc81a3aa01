// SPDX-License-Identifier: MIT
// duet run: finds all pairs of a scene on two devices and says where the time
// went; with --steps it advances a scene that moves.
//
// The first step warms up; of the others the one with the median time is
// shown, so that its stages belong together.
#include "base/error.h"
#include "base/text.h"
#include "cli/command_text.h"
#include "cli/commands.h"
#include "cli/commands/cluster.h"
#include "cli/draw/snapshot.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/run_report.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "tuner/sorted_pairs.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct arguments {
    scene_options scene;
    plan_options plan;
    level_options level;
    const char *pair;
    uint64_t repeat;
    uint64_t steps;      // 0: the scene is not advanced
    const char *picture; // a PNG of the last step
    const char *frames;  // a folder for PNGs, 30 of a second of the scene
    const char *record;  // where the scene's commands go
    const char *replay;  // where they come from
    bool resident;
    bool transforms;
    bool compact;
    bool ordered;
    const char *pairs_path;
    bool check;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    SCENE_LEVEL_OPTION_ROWS(level),
    OPTION_COUNT("repeat", repeat, "K", "steps that are timed, after one to warm up (5)", 1,
                 100000),
    OPTION_FLAG("resident", resident, "send the objects once, and leave them on the devices"),
    OPTION_FLAG("transforms", transforms,
                "send sizes once, and for each step only centres and rotations"),
    OPTION_FLAG("compact", compact, "the same, with rotations rounded to 16 bits: 20 bytes a box"),
    OPTION_FLAG("ordered", ordered, "put the objects into the order of their cells beforehand"),
    OPTION_COUNT("steps", steps, "K", "let a scene that moves go on by K steps", 1, 1000000000),
    OPTION_OUTPUT("picture", picture, "F.png", "draw the scene after the last step"),
    OPTION_TEXT("frames", frames, "DIR", "draw 30 pictures a second of the scene"),
    OPTION_OUTPUT("record", record, "F.replay", "record commands, steps and the state's hash"),
    OPTION_INPUT("replay", replay, "F.replay",
                 "give the scene recorded commands, and compare the hash"),
    OPTION_OUTPUT("pairs", pairs_path, "OUT.csv",
                  "write the pairs, a line each, ascending; - is stdout"),
    OPTION_FLAG("check", check, "compare the pairs with the plain C reference"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

// --steps advances a scene; without it one state is stepped again and again.
static const option_rule rules[] = {
    {"picture", OPTION_NEEDS, "steps"},
    {"frames", OPTION_NEEDS, "steps"},
    {"record", OPTION_NEEDS, "steps"},
    {"replay", OPTION_NEEDS, "steps"},
    {"repeat", OPTION_EXCLUDES, "steps"},
    {"resident", OPTION_EXCLUDES, "steps"},
    {"pairs", OPTION_EXCLUDES, "steps"},
    {"transforms", OPTION_EXCLUDES, "steps"},
    {"check", OPTION_EXCLUDES, "steps"},
    {"level", OPTION_EXCLUDES, "steps"},
    {"missed", OPTION_EXCLUDES, "steps"},
    {"false-rate", OPTION_EXCLUDES, "steps"},
    {"resident", OPTION_EXCLUDES, "transforms"},
    {"compact", OPTION_EXCLUDES, "transforms"},
    {"compact", OPTION_EXCLUDES, "resident"},
    {"compact", OPTION_EXCLUDES, "steps"},
    {"compact", OPTION_EXCLUDES, "check"},
    {"ordered", OPTION_EXCLUDES, "steps"},
    {0},
};

// Pictures of bodies are of pixels.
static const char *refuse(const void *given, char **operands)
{
    const char *path = ((const arguments *)given)->picture;
    size_t n = path ? strlen(path) : 0;
    (void)operands;
    return !path || (n >= 5 && strcmp(path + n - 4, ".png") == 0)
               ? NULL
               : "--picture: the name of a run's picture ends with .png";
}

static const command_line line = {
    .name = "run",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Finds all pairs of boxes that collide, on two devices, and says where the time\n"
             "went. SCENE is a name of 'duet scenes' or a Lua file; FILE is .npy, or numbers\n"
             "as text; - is stdin.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

// ---------------------------------------------------------------- one state of a scene

static bool write_pairs(const char *path, const duet_pair *pairs, uint64_t n, duet_error *err)
{
    text lines = {0};
    for (uint64_t i = 0; i < n; ++i)
        text_add(&lines, "%" PRIu32 ",%" PRIu32 "\n", pairs[i].a, pairs[i].b);
    return say_to_file(&lines, path, err);
}

static bool compare(const duet_scene *scene, duet_level level, const duet_pair *pairs, uint64_t n,
                    reference_check *check, duet_error *err)
{
    duet_pair *expected = NULL;
    if (!inputs_find_reference(scene, level, &expected, &check->reference, err))
        return false;
    sorted_pairs_count wrong = {0};
    sorted_pairs_compare(pairs, n, expected, check->reference, sorted_pairs_count_wrong, &wrong);
    check->extra = wrong.added;
    check->missing = wrong.missed;
    duet_free(expected);
    return true;
}

// The pairs' ids are those that objects had before they were put in order.
static bool find_own_hash(timed *t, const uint32_t *ids, duet_error *err)
{
    duet_pair *pairs = sorted_pairs_of(&t->last, err);
    if (!pairs)
        return false;
    sorted_pairs_rename(pairs, t->last.pairs, ids);
    t->hash = duet_pairs_hash(pairs, t->last.pairs);
    free(pairs);
    return true;
}

// ids are what objects were called before they were put in order; NULL: they were not.
static bool use_pairs(const arguments *args, const duet_scene *scene, const uint32_t *ids,
                      duet_level level, const duet_result *result, reference_check *check,
                      duet_error *err)
{
    check->asked = args->check;
    if (!args->check && !args->pairs_path)
        return true;
    duet_pair *pairs = sorted_pairs_of(result, err);
    bool ok = pairs != NULL;
    if (ok && args->check)
        ok = compare(scene, level, pairs, result->pairs, check, err);
    if (ok && args->pairs_path && ids)
        sorted_pairs_rename(pairs, result->pairs, ids);
    if (ok && args->pairs_path)
        ok = write_pairs(args->pairs_path, pairs, result->pairs, err);
    free(pairs);
    return ok;
}

static duet_world *make_world(const arguments *args, const duet_scene *scene,
                              duet_device_pair *pair, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    if (!inputs_change_level(&args->level, &def, err) ||
        !inputs_change_plan(&args->plan, pair, args->pair, &def.plan, err))
        return NULL;
    def.separate_sizes = args->transforms;
    def.compact_transforms = args->compact;
    def.ordered = args->ordered;
    duet_world *world = duet_world_create(&def, err);
    bool idle_a = world && duet_device_pair_is_one(pair) && duet_world_get_plan(world)->share == 0;
    if (!idle_a || !args->plan.variants[0])
        return world;
    error_set(err, DUET_STATUS_BAD_ARGUMENT,
              "--variant-a: A and B are one device, which works as B; expected --variant");
    duet_world_destroy(world);
    return NULL;
}

// A plan that was given is kept; else the world gets the one that was measured.
// A store that cannot be read is told of, and the default plan does.
static bool choose_plan(const arguments *args, const duet_scene *scene, duet_world *world,
                        run_report *r, duet_error *err)
{
    r->plan_given = inputs_plan_given(&args->plan);
    r->profile.grade = DUET_GRADE_DEFAULT;
    if (r->plan_given || duet_scene_get_info(scene)->n == 0)
        return true;
    if (!duet_world_set_scene(world, scene, err))
        return false;
    duet_error failure = {0};
    if (!duet_world_load_profile(world, NULL, &r->profile, &failure))
        say_failed(&failure);
    return true;
}

static timed_sends sends(const arguments *args)
{
    if (args->resident)
        return TIMED_SENDS_NOTHING;
    return args->transforms || args->compact ? TIMED_SENDS_TRANSFORMS : TIMED_SENDS_OBJECTS;
}

static void write_tuning(const arguments *args, const char *path, const duet_device_pair *pair,
                         text *command)
{
    text_add(command, "duet tune");
    command_text_scene(command, path, &args->scene);
    command_text_pair(command, pair);
    command_text_level(command, &args->level);
    if (args->ordered)
        text_add(command, " --ordered");
}

// The world is stepped, its pairs are used, and all of it is told.
static bool run_world(const arguments *args, const char *path, const duet_scene *scene,
                      const uint32_t *ids, const duet_device_pair *pair, duet_world *world,
                      duet_error *err)
{
    timed t = {0};
    text tuning = {0};
    write_tuning(args, path, pair, &tuning);
    run_report r = {.scene = duet_scene_get_info(scene),
                    .pair = pair,
                    .plan = duet_world_get_plan(world),
                    .timed = &t,
                    .tuning = text_chars(&tuning),
                    .resident = args->resident,
                    .transforms = args->transforms,
                    .compact = args->compact,
                    .ordered = args->ordered};
    bool ok = choose_plan(args, scene, world, &r, err);
    duet_level level = duet_world_get_level(world);
    duet_accuracy accuracy;
    r.level = duet_level_get_info(level)->name;
    r.accuracy_given = inputs_accuracy_given(&args->level, &accuracy);
    ok = ok && timed_run(&t, world, scene, (uint32_t)args->repeat, sends(args), err);
    ok = ok && (!ids || find_own_hash(&t, ids, err));
    ok = ok && use_pairs(args, scene, ids, level, &t.last, &r.check, err);
    if (ok && args->json)
        ok = run_report_json(&r, err);
    else if (ok && !options_is_stdout(args->pairs_path))
        run_report_text(&r);
    if (ok && !reference_check_is_right(&r.check))
        ok = error_set(err, DUET_STATUS_WRONG_RESULT, "%s: the pairs differ from the reference's",
                       r.scene->name);
    timed_free(&t);
    text_free(&tuning);
    return ok && interrupt_check(err);
}

// ---------------------------------------------------------------- a scene that moves

// Where each step is timed by stages though a GPU then takes longer.
enum { FEW_STEPS = 64 };
enum { STAGES_MOST = 32, ROWS_TOLD = 10, FRAMES_A_SECOND = 30 };

// A run, and what it took by effect.
typedef struct moved {
    const arguments *args;
    const duet_scene *scene;
    duet_motion_def def;
    duet_motion *motion;
    duet_profile profile; // that it goes by
    duet_replay *replay;  // NULL: no recorded commands
    duet_motion_result last;
    snapshot look;
    progress shown;
    uint64_t done;
    uint64_t frames;
    double total_ms;
    double slowest_ms;
    uint64_t since_timed;  // steps, of those after the first
    uint64_t staged_steps; // up to the last timed one
    uint64_t timed_steps;
    struct {
        char name[24];
        double ms;
    } stages[STAGES_MOST];
    uint32_t n_stages;
} moved;

// Each timed step stands for those since the one before.
static void add_stage(moved *r, const duet_stage *stage)
{
    uint32_t i = 0;
    while (i < r->n_stages && strcmp(r->stages[i].name, stage->name) != 0)
        ++i;
    if (i == STAGES_MOST)
        return;
    if (i == r->n_stages)
        snprintf(r->stages[r->n_stages++].name, sizeof r->stages[0].name, "%s", stage->name);
    r->stages[i].ms += stage->ms * (double)r->since_timed;
}

static void add_stages(moved *r)
{
    ++r->since_timed;
    if (!r->last.timed)
        return;
    for (uint32_t i = 0; i < r->last.n_stages; ++i)
        add_stage(r, &r->last.stages[i]);
    r->staged_steps += r->since_timed;
    r->since_timed = 0;
    ++r->timed_steps;
}

// A frame where its time has come.
static bool draw_frame(moved *r, duet_error *err)
{
    double time = (double)r->done * r->def.dt;
    if (!r->args->frames || time * FRAMES_A_SECOND < (double)r->frames)
        return true;
    char path[4096];
    int n = snprintf(path, sizeof path, "%s/%05" PRIu64 ".png", r->args->frames, r->frames++);
    if (n < 0 || (size_t)n >= sizeof path)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "--frames: the folder's name is too long");
    return snapshot_frame(&r->look, path, r->motion, time, err);
}

static bool draw_picture(moved *r, duet_error *err)
{
    double time = (double)r->done * r->def.dt;
    return !r->args->picture || snapshot_picture(&r->look, r->args->picture, r->motion, time, err);
}

static bool make_folder(const char *path, duet_error *err)
{
    return !path || mkdir(path, 0777) == 0 || errno == EEXIST ||
           error_set(err, DUET_STATUS_IO_FAILED, "--frames: the folder %s cannot be made: %s", path,
                     strerror(errno));
}

static bool tell_step(moved *r, duet_error *err)
{
    duet_energy e;
    uint64_t every = r->args->steps / ROWS_TOLD;
    bool due = r->done == 1 || r->done == r->args->steps || (every > 0 && r->done % every == 0);
    if (!due || r->args->json)
        return true;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    progress_hide(&r->shown);
    printf("%9" PRIu64 " %9.3f %12.5g %12.5g %12.5g %12" PRIu64 " %12" PRIu64 " %9.2f\n", r->done,
           r->last.time, e.kinetic + e.turning, e.potential, e.kinetic + e.turning + e.potential,
           r->last.pairs, r->last.contacts, r->last.total_ms);
    fflush(stdout);
    return true;
}

static bool step(moved *r, duet_error *err)
{
    if (!(r->replay ? duet_replay_advance(r->replay, r->motion, &r->last, err)
                    : duet_motion_advance(r->motion, &r->last, err)))
        return false;
    ++r->done;
    if (r->done > 1) { // the first builds kernels and makes space
        r->total_ms += r->last.total_ms;
        r->slowest_ms = fmax(r->slowest_ms, r->last.total_ms);
        add_stages(r);
    }
    return tell_step(r, err) && draw_frame(r, err);
}

// Where no pairs are sought B does all.
static duet_plan plan_used(const moved *r)
{
    const duet_plan *of_pairs = duet_motion_get_plan(r->motion);
    duet_plan plan = of_pairs ? *of_pairs : duet_default_plan(r->def.pair);
    plan.share = of_pairs ? plan.share : 0;
    return plan;
}

// A step without pairs, or whose pairs B finds, leaves A idle.
static void tell_plan(const moved *r, const duet_plan *plan)
{
    const duet_profile *p = &r->profile;
    bool given = inputs_plan_given(&r->args->plan), known = p->grade < DUET_GRADE_STALE;
    printf("plan: ");
    if (given)
        printf("as given");
    else if (p->grade == DUET_GRADE_STALE)
        printf("the default, since the kernels changed after it was measured");
    else if (!known)
        printf("the default; 'duet tune --steps' measures a better one");
    else if (p->step_ms > 0)
        printf("from the profile, %s: %.3f ms a step", duet_grade_name(p->grade), p->step_ms);
    else
        printf("from the profile, %s: that of another number of bodies", duet_grade_name(p->grade));
    if (plan->share == 0 && !duet_device_pair_is_one(r->def.pair))
        printf("; A has nothing to do");
    printf("\n\n");
}

static void tell_begin(const moved *r)
{
    const duet_scene_info *info = duet_scene_get_info(r->scene);
    if (r->args->json)
        return;
    printf("%s: %s, %uD; effects:", info->name, table_things(info->n, "box", "boxes").chars,
           info->dims);
    uint32_t effects = duet_motion_get_effects(r->motion);
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (effects & bit)
            printf(" %s", duet_effect_name(bit));
    printf("%s\n%s of %.6g s\n", effects ? "" : " none",
           table_things(r->def.substeps, "substep", "substeps").chars, r->def.dt / r->def.substeps);
    duet_plan plan = plan_used(r);
    run_report_devices(r->def.pair, &plan);
    tell_plan(r, &plan);
    printf("%9s %9s %12s %12s %12s %12s %12s %9s\n", "step", "time", "kinetic", "potential",
           "energy", "pairs", "contacts", "ms");
}

static double mean_ms(const moved *r)
{
    return r->done > 1 ? r->total_ms / (double)(r->done - 1) : 0.0;
}

static void tell_stage(table *t, const char *name, double ms, double whole)
{
    double part = whole > 0 ? ms / whole : 0.0;
    table_cell(t, "%s", name);
    table_cell(t, "%.3f", ms);
    table_cell(t, "%.1f", 100 * part);
    table_cell(t, "%s", table_bar(part, 24).chars);
}

// What no stage has is the host's own work and waits. Stages of two devices may take more
// together than the step does.
static void tell_times(const moved *r)
{
    table t = table_begin("lrrl");
    double mean = mean_ms(r), all = 0;
    for (uint32_t i = 0; i < r->n_stages; ++i)
        all += r->stages[i].ms / (double)r->staged_steps;
    double whole = fmax(mean, all);
    table_words(&t, "", "ms a step", "%", "", NULL);
    for (uint32_t i = 0; i < r->n_stages; ++i)
        tell_stage(&t, r->stages[i].name, r->stages[i].ms / (double)r->staged_steps, whole);
    if (all < mean)
        tell_stage(&t, "host and waits", mean - all, whole);
    table_print(&t, stdout);
    if (r->timed_steps + 1 < r->done)
        printf("of %s\n", table_things(r->timed_steps, "timed step", "timed steps").chars);
    printf("\n%.3f ms a step after the first, the slowest %.3f: %.4g steps a second\n", mean,
           r->slowest_ms, mean > 0 ? 1e3 / mean : 0.0);
}

static void tell_end(const moved *r, uint64_t hash)
{
    putchar('\n');
    if (r->n_stages > 0)
        tell_times(r);
    else if (duet_motion_get_effects(r->motion) == 0)
        printf("nothing is called for, so that a step launches nothing\n");
    printf("state hash %016" PRIx64 "\n", hash);
}

static bool tell_json(moved *r, uint64_t hash, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "scene", duet_scene_get_info(r->scene)->name);
    cJSON_AddNumberToObject(o, "objects", duet_motion_get_count(r->motion));
    duet_plan plan = plan_used(r);
    json_add_plan(o, plan.share / (double)DUET_SHARE_ONE, duet_mode_name(plan.mode), plan.variant_a,
                  plan.variant_b);
    cJSON_AddStringToObject(o, "profile",
                            inputs_plan_given(&r->args->plan) ? "given"
                                                              : duet_grade_name(r->profile.grade));
    cJSON_AddNumberToObject(o, "steps", (double)r->done);
    cJSON_AddNumberToObject(o, "time", r->last.time);
    cJSON_AddNumberToObject(o, "ms_a_step", mean_ms(r));
    cJSON_AddNumberToObject(o, "pairs", (double)r->last.pairs);
    cJSON_AddNumberToObject(o, "contacts", (double)r->last.contacts);
    cJSON_AddNumberToObject(o, "kinetic", e.kinetic + e.turning);
    cJSON_AddNumberToObject(o, "potential", e.potential);
    json_add_hash(o, hash);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (duet_motion_get_effects(r->motion) & bit)
            cJSON_AddItemToArray(effects, cJSON_CreateString(duet_effect_name(bit)));
    cJSON *stages = cJSON_AddObjectToObject(o, "stages_ms");
    for (uint32_t i = 0; i < r->n_stages; ++i)
        cJSON_AddNumberToObject(stages, r->stages[i].name,
                                r->stages[i].ms / (double)r->staged_steps);
    cJSON_AddNumberToObject(o, "timed_steps", (double)r->timed_steps);
    return say_json(o, err);
}

// As choose_plan. Where nothing happens there is nothing to choose.
static void choose_motion_plan(moved *r)
{
    duet_error failure = {0};
    bool happens = duet_motion_get_count(r->motion) > 0 && duet_motion_get_effects(r->motion) != 0;
    r->profile.grade = DUET_GRADE_DEFAULT;
    if (happens && !inputs_plan_given(&r->args->plan) &&
        !duet_motion_load_profile(r->motion, NULL, &r->profile, &failure))
        say_failed(&failure);
}

static bool open_motion(moved *r, duet_device_pair *pair, duet_error *err)
{
    r->def = duet_scene_motion_def(r->scene, pair);
    r->def.stage_times = r->args->steps <= FEW_STEPS;
    if (!inputs_change_plan(&r->args->plan, pair, r->args->pair, &r->def.plan, err))
        return false;
    r->motion = duet_motion_create_from_scene(&r->def, r->scene, NULL, err);
    if (r->motion)
        choose_motion_plan(r);
    return r->motion && snapshot_begin(&r->look, &r->def, r->scene, r->motion, err);
}

static bool open_replay(moved *r, duet_error *err)
{
    if (!r->args->replay)
        return true;
    r->replay = duet_replay_create(r->args->replay, err);
    uint64_t recorded = duet_replay_get_info(r->replay).steps;
    return r->replay && (r->args->steps <= recorded ||
                         error_set(err, DUET_STATUS_BAD_ARGUMENT,
                                   "--steps %" PRIu64 ": %s has %" PRIu64 " recorded steps",
                                   r->args->steps, r->args->replay, recorded));
}

static bool save_recording(moved *r, duet_error *err)
{
    return !r->args->record || duet_motion_save_recording(r->motion, r->args->record, err);
}

static bool run_steps(moved *r, duet_error *err)
{
    // The picture is drawn at the start too: where it cannot be written, that is told at once.
    bool ok = make_folder(r->args->frames, err) && draw_frame(r, err) && draw_picture(r, err);
    r->shown = progress_begin("step", r->args->steps);
    while (ok && r->done < r->args->steps && !interrupt_asked()) {
        ok = step(r, err);
        progress_show(&r->shown, r->done);
    }
    progress_end(&r->shown);
    uint64_t hash = 0;
    ok = ok && duet_motion_get_hash(r->motion, &hash, err) && draw_picture(r, err) &&
         save_recording(r, err);
    if (ok && r->args->json)
        return tell_json(r, hash, err);
    if (ok)
        tell_end(r, hash);
    return ok && interrupt_check(err);
}

// Advances the scene and tells what was done: energy and pairs as it goes, then
// the time of each effect. Ctrl-C ends it with what was done until then.
static bool run_motion(const arguments *args, const duet_scene *scene, duet_device_pair *pair,
                       duet_error *err)
{
    moved r = {.args = args, .scene = scene};
    bool ok = open_motion(&r, pair, err) && open_replay(&r, err) &&
              (!args->record || duet_motion_record(r.motion, err));
    if (ok)
        tell_begin(&r);
    ok = ok && run_steps(&r, err);
    snapshot_end(&r.look);
    duet_replay_destroy(r.replay);
    duet_motion_destroy(r.motion);
    return ok;
}

// ---------------------------------------------------------------- the command

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool moves = args->steps > 0;
    uint32_t *ids = NULL;
    bool ready = scene && (!args->ordered || inputs_put_in_order(scene, pair, &ids, err));
    duet_world *world = ready && !moves ? make_world(args, scene, pair, err) : NULL;
    bool ok = false;
    if (ready && moves)
        ok = run_motion(args, scene, pair, err);
    else
        ok = world && run_world(args, operands[0], scene, ids, pair, world, err);
    duet_world_destroy(world);
    duet_free(ids);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

// Each rank would do all of the work. The first says so, and the others end as if all were well:
// a launcher ends the job with the first that fails.
static bool refuse_job(int *status)
{
    unsigned long rank = 0, n_ranks = 0;
    if (!cluster_job(&rank, &n_ranks) || n_ranks < 2)
        return false;
    *status = EXIT_OK;
    if (rank == 0)
        *status =
            say_wrong("run",
                      "this is an MPI job of %lu ranks, and each would find all pairs; expected "
                      "'mpirun -np %lu duet cluster'",
                      n_ranks, n_ranks);
    return true;
}

int command_run(int argc, char **argv)
{
    int status;
    if (refuse_job(&status))
        return status;
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT,
                      .plan = PLAN_OPTIONS_DEFAULT,
                      .level = LEVEL_OPTIONS_DEFAULT,
                      .repeat = 5};
    return options_run(&line, argc, argv, &args, run);
}
