// SPDX-License-Identifier: MIT
// duet run: finds all pairs of a scene on two devices and says where the time
// went.
//
// The first step warms up; of the others the one with the median time is
// shown, so that its stages belong together.
#include "base/error.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/commands/run_motion.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/options.h"
#include "cli/report/run_report.h"
#include "cli/say.h"
#include "runtime/duet.h"
#include "tuner/pair_list.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    scene_options scene;
    plan_options plan;
    level_options level;
    const char *pair;
    uint64_t repeat;
    run_motion_options motion;
    bool resident;
    bool transforms;
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
    OPTION_FLAG("resident", resident, "leave the objects on the devices between the steps"),
    OPTION_FLAG("transforms", transforms, "send no sizes again, only centres and rotations"),
    OPTION_COUNT("steps", motion.steps, "K", "advance a scene that moves by K steps instead", 1,
                 1000000000),
    OPTION_TEXT("picture", motion.picture, "F.png", "draw the last of the steps"),
    OPTION_TEXT("frames", motion.frames, "DIR", "draw 30 pictures a second of the scene"),
    OPTION_TEXT("pairs", pairs_path, "OUT.csv", "write the pairs, a line each, ascending"),
    OPTION_FLAG("check", check, "compare the pairs with the plain C reference"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "run",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about =
        "Finds all pairs of boxes that collide, on two devices, and says where the time went.\n"
        "A scene is a Lua file; a file is .npy, or numbers as text.",
    .options = options,
};

static bool write_pairs(const char *path, const duet_pair *pairs, uint64_t n, duet_error *err)
{
    text lines = {0};
    for (uint64_t i = 0; i < n; ++i)
        text_add(&lines, "%" PRIu32 ",%" PRIu32 "\n", pairs[i].a, pairs[i].b);
    bool ok = text_ok(&lines, err);
    ok = ok && text_write_file(path, text_chars(&lines), lines.length, err);
    text_free(&lines);
    return ok;
}

static bool compare(const duet_scene *scene, duet_level level, const duet_pair *pairs, uint64_t n,
                    verdict *v, duet_error *err)
{
    duet_pair *expected = NULL;
    if (!duet_reference(scene, level, &expected, &v->reference, err))
        return false;
    pair_list_count wrong = {0};
    pair_list_compare(pairs, n, expected, v->reference, pair_list_count_wrong, &wrong);
    v->extra = wrong.added;
    v->missing = wrong.missed;
    duet_free(expected);
    return true;
}

static bool use_pairs(const arguments *args, const duet_scene *scene, duet_level level,
                      const duet_result *result, verdict *v, duet_error *err)
{
    v->asked = args->check;
    if (!args->check && !args->pairs_path)
        return true;
    duet_pair *pairs = pair_list_sorted(result, err);
    bool ok = pairs != NULL;
    if (ok && args->pairs_path)
        ok = write_pairs(args->pairs_path, pairs, result->pairs, err);
    if (ok && args->check)
        ok = compare(scene, level, pairs, result->pairs, v, err);
    free(pairs);
    return ok;
}

static duet_world *make_world(const arguments *args, const duet_scene *scene,
                              duet_device_pair *pair, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    if (!inputs_change_level(&args->level, &def, err) ||
        !inputs_change_plan(&args->plan, &def.plan, err))
        return NULL;
    def.separate_sizes = args->transforms;
    return duet_world_create(&def, err);
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
    return args->transforms ? TIMED_SENDS_TRANSFORMS : TIMED_SENDS_OBJECTS;
}

// The world is stepped, its pairs are used, and all of it is told.
static bool run_world(const arguments *args, const duet_scene *scene, const duet_device_pair *pair,
                      duet_world *world, duet_error *err)
{
    timed t = {0};
    run_report r = {.scene = duet_scene_get_info(scene),
                    .pair = pair,
                    .plan = duet_world_get_plan(world),
                    .timed = &t,
                    .resident = args->resident,
                    .transforms = args->transforms};
    bool ok = choose_plan(args, scene, world, &r, err);
    duet_level level = duet_world_get_level(world);
    r.level = duet_level_get_info(level)->name;
    ok = ok && timed_run(&t, world, scene, (uint32_t)args->repeat, sends(args), err);
    ok = ok && use_pairs(args, scene, level, &t.last, &r.verdict, err);
    if (ok && args->json)
        ok = run_report_json(&r, err);
    else if (ok)
        run_report_text(&r);
    if (ok && !verdict_is_right(&r.verdict))
        ok = error_set(err, DUET_STATUS_WRONG_RESULT, "%s: the pairs differ from the reference's",
                       r.scene->name);
    timed_free(&t);
    return ok && interrupt_check(err);
}

static bool run(const arguments *args, const char *path, duet_error *err)
{
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool moves = args->motion.steps > 0;
    duet_world *world = scene && !moves ? make_world(args, scene, pair, err) : NULL;
    bool ok = false;
    if (scene && moves)
        ok = run_motion(&args->motion, scene, pair, &args->plan, err);
    else
        ok = world && run_world(args, scene, pair, world, err);
    duet_world_destroy(world);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

int command_run(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT,
                      .plan = PLAN_OPTIONS_DEFAULT,
                      .level = LEVEL_OPTIONS_DEFAULT,
                      .repeat = 5};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    args.motion.json = args.json;
    if (!args.motion.steps && (args.motion.picture || args.motion.frames))
        return say_wrong("run", "--picture and --frames draw a scene that moves; give --steps K");
    return run(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
