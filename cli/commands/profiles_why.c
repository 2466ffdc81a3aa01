// SPDX-License-Identifier: MIT
// duet profiles why: which profile a scene would get here, and why.
#define _POSIX_C_SOURCE 200809L
#include "cli/commands/profiles.h"
#include "cli/inputs.h"
#include "cli/options.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "runtime/selection/profile_subject.h"
#include "runtime/task/task.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

typedef struct arguments {
    scene_options scene;
    level_options level;
    const char *pair;
    const char *task; // a task file; NULL: a scene is asked for
    const char *store;
    bool moving;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    SCENE_LEVEL_OPTION_ROWS(level),
    PROFILE_OPTION_ROW(store),
    OPTION_INPUT("task", task, "FILE", "look up a task, as 'duet run --task' does"),
    OPTION_FLAG("moving", moving, "look up a moving scene's steps, as 'duet run --steps' does"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

// A motion finds all pairs.
static const option_rule rules[] = {{"level missed false-rate", OPTION_EXCLUDES, "moving"},
                                    {"moving level missed false-rate", OPTION_EXCLUDES, "task"},
                                    {0}};

static const command_line line = {
    .name = "profiles why",
    .operands = "[SCENE|FILE]",
    .instead = "task",
    .about = "Says which profile an application with this scene would get here, and why. The\n"
             "grades are tried from the best down; docs/store.md explains them.",
    .options = options,
    .rules = rules,
};

// A question and its answer.
typedef struct answer {
    profile_subject asked;
    profile_found found;
    text why; // a line for each grade
    duet_plan fallback;
    bool one_device;
    char whole[80]; // the selector of the device that A is a part of, or is
} answer;

static bool read_world(const arguments *args, const duet_scene *scene, duet_device_pair *pair,
                       profile_subject *asked, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    duet_world *world =
        inputs_change_level(&args->level, &def, err) ? duet_world_create(&def, err) : NULL;
    bool ok =
        world && duet_world_set_scene(world, scene, err) && profile_subject_read(world, asked, err);
    duet_world_destroy(world);
    return ok;
}

static bool read_motion(const duet_scene *scene, duet_device_pair *pair, profile_subject *asked,
                        duet_error *err)
{
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    duet_motion *motion = duet_motion_create_from_scene(&def, scene, NULL, err);
    bool ok = motion && profile_subject_read_motion(motion, asked, err);
    duet_motion_destroy(motion);
    return ok;
}

// With many millions of objects it takes seconds.
static bool read_subject(const arguments *args, const duet_scene *scene, duet_device_pair *pair,
                         profile_subject *asked, duet_error *err)
{
    progress p = progress_begin("looking at the objects", 0);
    progress_follow(&p);
    progress_show(&p, 0);
    bool ok = args->moving ? read_motion(scene, pair, asked, err)
                           : read_world(args, scene, pair, asked, err);
    progress_end(&p);
    return ok;
}

static void add_device(cJSON *o, const char *name, const profile_env *env)
{
    cJSON *device = cJSON_AddObjectToObject(o, name);
    json_add(device, STRING("name", env->device.name), STRING("part", env->part ? env->part : ""),
             STRING("driver", env->driver));
}

// "2026-11-21 08:17", UTC; empty for 0.
static void add_created(cJSON *o, int64_t calendar_ns)
{
    char date[32] = "";
    time_t seconds = (time_t)(calendar_ns / 1000000000);
    struct tm parts;
    if (calendar_ns > 0 && gmtime_r(&seconds, &parts))
        strftime(date, sizeof date, "%Y-%m-%d %H:%M", &parts);
    json_add(o, STRING("created", date));
}

static void add_plan(cJSON *o, const answer *a)
{
    const profile_plan *plan = &a->found.plan;
    const duet_plan *fallback = &a->fallback;
    if (a->found.grade != PROFILE_DEFAULT)
        json_add_plan(o, plan->share / (double)PROFILE_SHARE_ONE, plan->mode, plan->variant_a,
                      plan->variant_b);
    else
        json_add_plan(o, fallback->share / (double)DUET_SHARE_ONE, duet_mode_name(fallback->mode),
                      fallback->variant_a, fallback->variant_b);
}

// null: not known of this workload.
static void add_figures(cJSON *o, const profile_found *found)
{
    if (!*found->verdict) {
        static const char *const names[] = {"ms", "gain", "gain_low", "gain_high", "verdict"};
        for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
            cJSON_AddNullToObject(o, names[i]);
        return;
    }
    json_add(o, NUMBER("ms", found->median_ns * 1e-6),
             INTERVAL("gain", found->gain, found->gain_low, found->gain_high),
             STRING("verdict", found->verdict));
}

static cJSON *describe(const answer *a)
{
    const profile_found *found = &a->found;
    text workload = {0};
    profile_workload_text(&a->asked.workload, &workload);
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("workload", text_chars(&workload)));
    text_free(&workload);
    add_device(o, "a", &a->asked.pair.a);
    add_device(o, "b", &a->asked.pair.b);
    json_add(o, FLAG("one_device", a->one_device), STRING("whole", a->whole),
             STRING("grade", profile_grade_name(found->grade)));
    add_plan(o, a);
    if (found->grade != PROFILE_DEFAULT) {
        json_add(o, STRING("level", found->plan.level),
                 NUMBER("share_low", found->share_low / (double)PROFILE_SHARE_ONE),
                 NUMBER("share_high", found->share_high / (double)PROFILE_SHARE_ONE));
        add_figures(o, found);
        json_add_rates(o, (double)found->true_pairs, found->missed_rate, found->false_rate);
        json_add_whole(o, found->whole_ns * 1e-6, found->whole_gain, found->whole_gain_low,
                       found->whole_gain_high);
        json_add(o, STRING("uid", found->uid));
        add_created(o, found->created_ns);
    }
    json_add_lines(o, "why", text_chars(&a->why));
    return o;
}

// The names by which the report finds the lines of "why" that tell of a grade.
static void add_grades(cJSON *o)
{
    cJSON *grades = cJSON_AddArrayToObject(o, "grades");
    for (int grade = 0; grade < PROFILE_DEFAULT; ++grade)
        cJSON_AddItemToArray(grades, cJSON_CreateString(profile_grade_name((profile_grade)grade)));
}

static bool look_and_tell(const arguments *args, answer *a, duet_error *err)
{
    profile_request request = profile_subject_request(&a->asked);
    if (!profile_subject_look(args->store, &request, &a->found, &a->why, err))
        return false;
    cJSON *o = describe(a);
    if (!args->json)
        add_grades(o);
    return rendering_tell(o, args->json, "cli/report/why.lua", err);
}

static bool ask_scene(const arguments *args, const char *path, duet_device_pair *pair, answer *a,
                      duet_error *err)
{
    duet_scene *scene = inputs_load_objects(path, &args->scene, err);
    bool ok = scene && read_subject(args, scene, pair, &a->asked, err);
    ok = ok && look_and_tell(args, a, err);
    duet_scene_destroy(scene);
    return ok;
}

static bool ask_task(const arguments *args, duet_device_pair *pair, answer *a, duet_error *err)
{
    task *t = inputs_load_task(args->task, &args->scene, err);
    bool ok =
        t && profile_subject_read_task(t, pair, &a->asked, err) && look_and_tell(args, a, err);
    task_destroy(t);
    return ok;
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    answer a = {0};
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    if (!pair)
        return false;
    a.fallback = duet_default_plan(pair);
    a.one_device = duet_device_pair_is_one(pair);
    const char *selector = duet_device_pair_get_info(pair, 0)->selector;
    snprintf(a.whole, sizeof a.whole, "%.*s", (int)strcspn(selector, "["), selector);
    bool ok =
        args->task ? ask_task(args, pair, &a, err) : ask_scene(args, operands[0], pair, &a, err);
    text_free(&a.why);
    duet_device_pair_destroy(pair);
    return ok;
}

int profiles_why(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .level = LEVEL_OPTIONS_DEFAULT};
    return options_run(&line, argc, argv, &args, run);
}
