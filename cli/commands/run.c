// SPDX-License-Identifier: MIT
// duet run: finds all pairs of a scene on two devices and says where the time
// went; with --steps it advances a scene that moves (run_motion.c).
//
// The first step warms up; of the others the one with the median time is
// shown, so that its stages belong together.
#include "cli/commands/run.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/command_text.h"
#include "cli/commands.h"
#include "cli/commands/cluster.h"
#include "cli/frames.h"
#include "cli/interrupt.h"
#include "cli/report/run_report.h"
#include "cli/say.h"
#include "tuner/sorted_pairs.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    OPTION_INPUT("task", task, "FILE",
                 "run a kernel of your own: a task file (docs/tutorial_task.md)"),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    SCENE_LEVEL_OPTION_ROWS(level),
    OPTION_COUNT("repeat", repeat, "K", "steps that are timed, after one to warm up (5)", 1,
                 100000),
    OPTION_TEXT("input", input, "I",
                "what each step is sent (host): host, resident, transforms or compact"),
    OPTION_FLAG("ordered", ordered, "put the objects into the order of their cells beforehand"),
    OPTION_COUNT("steps", steps, "K", "advance a moving scene by K steps", 1, 1000000000),
    OPTION_OUTPUT("picture", picture, "F.png", "draw the scene after the last step"),
    OPTION_TEXT("frames", frames, "DIR", "draw 30 pictures a second of the scene"),
    OPTION_TEXT("format", format, "F", "what frames are (png): png, or vtu, which ParaView opens"),
    OPTION_OUTPUT("record", record, "F.replay", "record commands, steps and the state's hash"),
    OPTION_INPUT("replay", replay, "F.replay", "replay recorded commands, and compare the hash"),
    OPTION_OUTPUT("pairs", pairs_path, "OUT.csv",
                  "write the pairs, a line each, ascending; - is stdout"),
    OPTION_FLAG("check", check, "compare the pairs with the plain C reference"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

// --steps advances a scene; without it one state is stepped again and again.
static const option_rule rules[] = {
    {"picture frames record replay", OPTION_NEEDS, "steps"},
    {"format", OPTION_NEEDS, "frames"},
    {"input ordered steps pairs check level missed false-rate", OPTION_EXCLUDES, "task"},
    {"repeat input ordered pairs check level missed false-rate", OPTION_EXCLUDES, "steps"},
    {0},
};

// Pictures of bodies are of pixels. The reference knows no rotations that were rounded.
static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    size_t n = args->picture ? strlen(args->picture) : 0;
    timed_input input;
    frames_format format;
    if (!operands[0] && !args->task)
        return "SCENE|FILE is missing; 'duet run --help' says what it is";
    if (operands[0] && args->task)
        return "--task: the file says what is run; give no scene";
    if (args->picture && (n < 5 || strcmp(args->picture + n - 4, ".png") != 0))
        return "--picture: the name of a run's picture ends with .png";
    if (!timed_input_named(args->input, &input))
        return "--input: give host (all of the objects), resident (nothing: they stay on the "
               "devices), transforms (centres and rotations) or compact (the same in 20 bytes)";
    if (!frames_format_named(args->format, &format))
        return "--format: give png (pictures) or vtu (bodies and contacts for ParaView)";
    return args->check && input == TIMED_INPUT_COMPACT
               ? "--check and --input compact do not go together"
               : NULL;
}

static const command_line line = {
    .name = "run",
    .operands = "[SCENE|FILE]",
    .least_operands = 0,
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

static timed_input input_of(const arguments *args)
{
    timed_input input = TIMED_INPUT_HOST;
    timed_input_named(args->input, &input); // which it is: refuse() looked
    return input;
}

static duet_world *make_world(const arguments *args, const duet_scene *scene,
                              duet_device_pair *pair, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    if (!inputs_change_level(&args->level, &def, err) ||
        !inputs_change_plan(&args->plan, pair, args->pair, &def.plan, err))
        return NULL;
    timed_input input = input_of(args);
    def.separate_sizes = input == TIMED_INPUT_TRANSFORMS;
    def.compact_transforms = input == TIMED_INPUT_COMPACT;
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
                    .input = input_of(args),
                    .ordered = args->ordered};
    bool ok = choose_plan(args, scene, world, &r, err);
    duet_level level = duet_world_get_level(world);
    duet_accuracy accuracy;
    r.level = duet_level_get_info(level)->name;
    r.accuracy_given = inputs_accuracy_given(&args->level, &accuracy);
    ok = ok && timed_run(&t, world, scene, (uint32_t)args->repeat, r.input, err);
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

// ---------------------------------------------------------------- the command

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    if (args->task)
        return run_task(args, err);
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
                      .input = "host",
                      .format = "png",
                      .repeat = 5};
    return options_run(&line, argc, argv, &args, run);
}
