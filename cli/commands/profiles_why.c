// SPDX-License-Identifier: MIT
// duet profiles why: which profile a scene would get here, and why.
#include "cli/commands/profiles.h"
#include "cli/inputs.h"
#include "cli/options.h"
#include "cli/report/json.h"
#include "cli/report/profile_report.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "runtime/selection/profile_subject.h"
#include "runtime/task/task.h"

#include <string.h>

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

static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    return !operands[0] && !args->task ? "SCENE|FILE is missing; 'duet profiles why --help' says "
                                         "what it is"
           : operands[0] && args->task ? "--task: the file says what is looked up; give no scene"
                                       : NULL;
}

static const command_line line = {
    .name = "profiles why",
    .operands = "[SCENE|FILE]",
    .least_operands = 0,
    .most_operands = 1,
    .about = "Says which profile an application with this scene would get here, and why. The\n"
             "grades are tried from the best down; docs/store.md explains them.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
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

static void add_device_row(table *t, const char *label, const profile_env *env)
{
    profile_report_device_row(t, label,
                              &(profile_entry_device){.name = env->device.name,
                                                      .part = env->part,
                                                      .driver = env->driver});
}

static void print_subject(const answer *a)
{
    text workload = {0};
    profile_workload_text(&a->asked.workload, &workload);
    table t = table_begin("ll");
    table_words(&t, "workload", say_name(text_chars(&workload)).chars, NULL);
    text_free(&workload);
    if (!a->one_device)
        add_device_row(&t, "A", &a->asked.pair.a);
    add_device_row(&t, a->one_device ? "device" : "B", &a->asked.pair.b);
    table_print(&t, stdout);
}

// How many characters of the row are blanks and the grade behind them; 0: it names no grade.
static size_t grade_length(const char *row)
{
    size_t blanks = strspn(row, " ");
    for (int grade = 0; blanks > 0 && grade < PROFILE_DEFAULT; ++grade) {
        const char *name = profile_grade_name((profile_grade)grade);
        if (strncmp(row + blanks, name, strlen(name)) == 0)
            return blanks + strlen(name);
    }
    return 0;
}

// Lines as "  exact        yes: ..." become rows of a table; others are printed as they are.
static void print_grades(const char *why)
{
    table t = table_begin("ll");
    for (const char *at = why; *at;) {
        char row[512];
        int length = (int)strcspn(at, "\n");
        snprintf(row, sizeof row, "%.*s", length, at);
        at += length + (at[length] == '\n');
        size_t grade = grade_length(row);
        if (grade > 0) {
            table_cell(&t, "%.*s", (int)grade, row);
            table_words(&t, say_name(row + grade + strspn(row + grade, " ")).chars, NULL);
            continue;
        }
        table_print(&t, stdout);
        t = table_begin("ll");
        say_lines(row);
        putchar('\n');
    }
    table_print(&t, stdout);
}

static table_text whole_text(const answer *a)
{
    const profile_found *found = &a->found;
    return table_whole(a->asked.pair.a.device.name, a->whole, found->whole_gain,
                       found->whole_gain_low, found->whole_gain_high);
}

static void print_text(const answer *a)
{
    const profile_found *found = &a->found;
    const profile_plan *plan = &found->plan;
    print_subject(a);
    printf("\n");
    print_grades(text_chars(&a->why));
    printf("\n");
    printf("%s: ", profile_grade_name(found->grade));
    if (found->grade == PROFILE_DEFAULT) {
        if (a->one_device)
            printf("kernels %s, of which nothing is known\n", a->fallback.variant_b);
        else
            printf("share %.4f, mode %s, A %s, B %s, of which nothing is known\n",
                   a->fallback.share / (double)DUET_SHARE_ONE, duet_mode_name(a->fallback.mode),
                   a->fallback.variant_a, a->fallback.variant_b);
        return;
    }
    if (a->one_device)
        printf("kernels %s, level %s\n", say_name(plan->variant_b).chars,
               say_name(plan->level).chars);
    else
        printf("share %.4f, mode %s, A %s, B %s, level %s\n",
               plan->share / (double)PROFILE_SHARE_ONE, say_name(plan->mode).chars,
               say_name(plan->variant_a).chars, say_name(plan->variant_b).chars,
               say_name(plan->level).chars);
    if (!*found->verdict) {
        printf("the plan of another workload: what a step takes and gains here is not known\n");
        return;
    }
    table_text gain =
        table_gain(plan->share, found->gain, found->gain_low, found->gain_high, found->verdict);
    printf("a step of %.4g ms%s%s\n", found->median_ns * 1e-6, a->one_device ? "" : ", ",
           a->one_device ? "" : say_name(gain.chars).chars);
    if (found->whole_ns > 0)
        printf("%s\n", say_name(whole_text(a).chars).chars);
    if (found->true_pairs > 0)
        printf(
            "of %s pairs that collide, level %s misses %.3g %% and adds %.3g %% that are false\n",
            table_count((uint64_t)found->true_pairs).chars, say_name(plan->level).chars,
            100 * found->missed_rate, 100 * found->false_rate);
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

static bool print_json(const answer *a, duet_error *err)
{
    const profile_found *found = &a->found;
    text workload = {0};
    profile_workload_text(&a->asked.workload, &workload);
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("workload", text_chars(&workload)));
    text_free(&workload);
    json_add(o, STRING("grade", profile_grade_name(found->grade)));
    add_plan(o, a);
    if (found->grade != PROFILE_DEFAULT) {
        json_add(o, STRING("level", found->plan.level),
                 NUMBER("share_low", found->share_low / (double)PROFILE_SHARE_ONE),
                 NUMBER("share_high", found->share_high / (double)PROFILE_SHARE_ONE));
        add_figures(o, found);
        json_add_rates(o, (double)found->true_pairs, found->missed_rate, found->false_rate);
        json_add_whole(o, found->whole_ns * 1e-6, found->whole_gain, found->whole_gain_low,
                       found->whole_gain_high);
        json_add(o, STRING("uid", found->uid),
                 STRING("created", profile_report_when(found->created_ns).chars));
    }
    json_add_lines(o, "why", text_chars(&a->why));
    return say_json(o, err);
}

static bool look_and_tell(const arguments *args, answer *a, duet_error *err)
{
    profile_request request = profile_subject_request(&a->asked);
    if (!profile_subject_look(args->store, &request, &a->found, &a->why, err))
        return false;
    if (args->json)
        return print_json(a, err);
    print_text(a);
    return true;
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
