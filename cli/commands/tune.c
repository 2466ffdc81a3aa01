// SPDX-License-Identifier: MIT
// duet tune: finds how two devices share a scene's work best, and stores it.
//
// Each number of objects is a workload of its own. Ctrl-C keeps what was
// measured, and the same command goes on from there.
#include "cli/commands/tune.h"
#include "base/error.h"
#include "base/text_file.h"
#include "cli/command_text.h"
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/report/tune_report.h"
#include "cli/tune_config.h"
#include "runtime/task/task.h"
#include "tuner/strategy.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const option options[] = {
    OPTION_TEXT("config", config, "FILE", "a tune.lua: workloads, strategy, budget, variants"),
    OPTION_INPUT("task", task, "FILE",
                 "tune a kernel of your own: a task file (docs/tutorial_task.md)"),
    OPTION_TEXT("objects", numbers, "LIST", "numbers of objects, with commas between them"),
    OPTION_COUNT("seed", scene.seed, "S",
                 "seed of the scene's random numbers; with --replay of its draws (0)", 0,
                 UINT32_MAX),
    OPTION_SETTINGS("set", scene.settings, "K=V",
                    "another parameter, as 'duet scenes SCENE' shows"),
    PAIR_OPTION_ROW(pair),
    OPTION_TEXT("strategy", strategy, "S",
                "how the share is searched, by the last three with the kernels: balance (default), "
                "fig12, grid, chunks, random, annealing or brute"),
    OPTION_TEXT("strategy-lua", strategy_path, "FILE",
                "script that returns a function from the history to the next share, or plan"),
    OPTION_TEXT("objective", objective, "O",
                "what is made small (time): time, or energy, where the system lets it be read"),
    OPTION_TEXT(
        "variants", variants, "LIST",
        "kernels to choose from, with commas between them (auto,simd,auto sort=radix,paper)"),
    OPTION_TEXT("search", search, "WHAT",
                "search the parameters of one kernel too, or of all: 'kernels'"),
    OPTION_TEXT(
        "query", query, "WHAT",
        "tune a query instead of a step: 'rays' or 'sweeps' with 'closest', 'any' or 'every'; "
        "'boxes', 'boxes itself', 'points', 'points nearest K'"),
    OPTION_COUNT("items", items, "N", "rays, boxes or points of the query (as many as objects)", 1,
                 UINT32_MAX),
    OPTION_COUNT("steps", steps, "K",
                 "tune a moving scene instead of a still step, by runs of K steps", 2, 1000000),
    OPTION_TEXT(
        "level", level.level, "LIST",
        "level of accuracy, or several to choose from (the scene's; all of them with --missed or "
        "--false-rate)"),
    ACCURACY_OPTION_ROWS(level),
    OPTION_NUMBER("budget", budget_seconds, "SECONDS", "time for each workload (no limit)", 0.001,
                  0),
    OPTION_COUNT("trials", budget_trials, "K", "trials for each workload (no limit)", 1,
                 UINT32_MAX),
    OPTION_COUNT("repeat", repeats, "K", "launches of a trial, after one to warm up (3)", 1, 32),
    OPTION_NUMBER("wait", wait_seconds, "SECONDS",
                  "how long to wait while other programs take the cores; 0: measure beside them "
                  "(DUET_WAIT, or 60)",
                  0, 0),
    OPTION_TEXT("profile", store, "FILE", "the profile file (DUET_PROFILE, or the user's own)"),
    OPTION_INPUT("replay", replay, "STORE",
                 "measure nothing: run strategies on the launches that a store keeps"),
    OPTION_FLAG("ordered", ordered, "put the objects into the order of their cells beforehand"),
    OPTION_FLAG("fresh", fresh, "measure again what an earlier run has finished"),
    OPTION_FLAG("keep", keep,
                "let applications load also what a strategy other than balance found"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

// A replay has these from its store, or does not do them.
static const option_rule rules[] = {
    {"config task set pair objective variants search query items level missed false-rate budget "
     "trials "
     "profile ordered fresh keep",
     OPTION_EXCLUDES, "replay"},
    {"config query items steps level missed false-rate ordered", OPTION_EXCLUDES, "task"},
    {0},
};

static const command_line line = {
    .name = "tune",
    .operands = "[SCENE|FILE]",
    .about = "Finds the kernels, the mode and the share with which two devices do a scene's\n"
             "work best, and keeps them in the profile file for 'duet run' and for\n"
             "applications. With --config a file names the scenes and fills the fields that\n"
             "no option gives. A profile that applications load is replaced only by one that\n"
             "is as well measured. Launches that other programs disturb are repeated; if most\n"
             "are, the tuning waits. --replay measures nothing and needs no device; SCENE and\n"
             "-n then choose among the workloads of the store.",
    .options = options,
    .rules = rules,
};

// ---------------------------------------------------------------- lists

// "1000,2000" as numbers.
static bool read_numbers(const char *list, number_list *numbers, duet_error *err)
{
    numbers->n = 0;
    for (const char *at = list; *at || numbers->n == 0;) {
        uint64_t number;
        const char *end = options_read_count(at, &number);
        if (!end || number > UINT32_MAX || (*end != ',' && *end != '\0') ||
            (*end == ',' && !end[1]) || numbers->n == MOST_NUMBERS)
            return bad_argument(
                err,
                "--objects '%s': give up to %d numbers with commas between them, as 250000,500000",
                list, MOST_NUMBERS);
        numbers->items[numbers->n++] = (int64_t)number;
        at = *end == ',' ? end + 1 : end;
    }
    return true;
}

// Cuts a copy of the list at its commas; a variant may hold spaces.
static bool cut_list(text *copy, const char *list, const char *name, const char **items,
                     uint32_t most, uint32_t *n, duet_error *err)
{
    text_add(copy, "%s", list);
    if (!text_ok(copy, err))
        return false;
    *n = 0;
    for (char *at = copy->chars; at;) {
        if (*n == most)
            return bad_argument(err, "%s: at most %u", name, most);
        items[(*n)++] = at;
        at = strchr(at, ',');
        if (at)
            *at++ = '\0';
    }
    return true;
}

// "sat6,sat15" as levels.
static bool read_levels(const char *list, tune_config *config, duet_error *err)
{
    text copy = {0};
    const char *names[DUET_LEVELS];
    duet_tune_def *def = &config->def;
    bool ok = cut_list(&copy, list, "--level", names, DUET_LEVELS, &def->n_levels, err);
    for (uint32_t i = 0; ok && i < def->n_levels; ++i)
        ok = inputs_read_level(names[i], &config->levels[i], err);
    text_free(&copy);
    return ok;
}

// Levels on the command line replace those of the file.
static bool change_levels(const level_options *asked, tune_config *config, duet_error *err)
{
    duet_accuracy accuracy;
    bool given = inputs_accuracy_given(asked, &accuracy);
    if (!given && !asked->level)
        return true;
    config->def.n_levels = 0;
    config->def.has_accuracy = given;
    config->def.accuracy = accuracy;
    if (asked->level && !read_levels(asked->level, config, err))
        return false;
    return config->def.n_levels < 2 || given ||
           bad_argument(err, "--level %s: to choose one of several, give --missed or --false-rate",
                        asked->level);
}

// ---------------------------------------------------------------- config

static bool add_scene(const arguments *args, const char *path, tune_config *config, duet_error *err)
{
    number_list numbers = {{-1}, 1};
    if (args->numbers && !read_numbers(args->numbers, &numbers, err))
        return false;
    config->n_workloads = numbers.n;
    for (uint32_t i = 0; i < numbers.n; ++i)
        config->workloads[i] = (config_workload){.scene = path,
                                                 .task = args->task,
                                                 .n = numbers.items[i],
                                                 .query = args->query,
                                                 .items = args->items,
                                                 .steps = (uint32_t)args->steps};
    return true;
}

static bool check_operands(const arguments *args, const char *path, duet_error *err)
{
    if (args->task)
        return !path ||
               bad_argument(err, "%s: with --task the file says what is tuned; expected no scene",
                            path);
    if (!path == !args->config)
        return bad_argument(err,
                            "give a scene, as 'duet tune paper', or a tune file with --config");
    if (args->config && args->numbers)
        return bad_argument(err, "--objects: with --config the file says how many");
    if (args->config && args->query)
        return bad_argument(err, "--query: with --config the file says what is asked");
    if (args->config && args->steps)
        return bad_argument(err, "--steps: with --config the file says which scenes move");
    return args->items == 0 || args->query ||
           bad_argument(err, "--items: give --query, whose items they are");
}

// From the tune file, or for the one scene; then what options say.
static bool make_config(arguments *args, const char *path, tune_config *config, duet_error *err)
{
    if (!check_operands(args, path, err))
        return false;
    if (args->config ? !tune_config_load(config, args->config, err)
                     : !add_scene(args, path, config, err))
        return false;
    if (args->strategy) {
        config->def.strategy = args->strategy;
        config->def.strategy_lua = NULL;
    }
    if (args->strategy_path) {
        config->def.strategy = "lua";
        text_free(&config->text);
        if (!text_read_lines(&config->text, args->strategy_path, err))
            return false;
        config->def.strategy_lua = text_chars(&config->text);
    }
    config->def.objective = args->objective ? args->objective : config->def.objective;
    config->def.search = args->search ? args->search : config->def.search;
    config->pair = args->pair ? args->pair : config->pair;
    config->def.budget_seconds =
        args->budget_seconds > 0 ? args->budget_seconds : config->def.budget_seconds;
    config->def.budget_trials =
        args->budget_trials > 0 ? (uint32_t)args->budget_trials : config->def.budget_trials;
    config->def.repeats = args->repeats > 0 ? (uint32_t)args->repeats : config->def.repeats;
    if (!change_levels(&args->level, config, err))
        return false;
    return !args->variants ||
           cut_list(&config->list, args->variants, "--variants", config->variants.names,
                    FIELD_NAMES, &config->def.n_variants, err);
}

// ---------------------------------------------------------------- workloads

static duet_tune_def make_def(const arguments *args, const tune_config *config, tune_report *report)
{
    duet_tune_def def = config->def;
    def.store = args->store;
    def.ordered = args->ordered;
    def.fresh = args->fresh;
    def.keep = args->keep ? DUET_KEEP_ALWAYS : DUET_KEEP_DEFAULT;
    def.strategy_name = args->strategy_path ? args->strategy_path : args->config;
    def.script = args->config ? text_chars(&config->text) : NULL;
    def.wait_seconds = args->wait_seconds;
    def.watch = tune_report_watch;
    def.watch_context = report;
    return def;
}

static scene_options options_of(const arguments *args, const config_workload *w)
{
    scene_options scene = args->scene;
    scene.n = w->n < 0 ? UINT64_MAX : (uint64_t)w->n;
    for (uint32_t i = 0; i < w->n_settings; ++i)
        option_list_add(&scene.settings, w->settings[i]);
    return scene;
}

// The command that runs the plan, which is added behind it; a query has none.
static void begin_command(text *command, const arguments *args, const config_workload *w,
                          const duet_device_pair *pair)
{
    scene_options asked = options_of(args, w);
    if (w->query)
        return;
    text_add(command, "duet run");
    if (w->task) {
        command_text_option(command, "task", w->task);
        command_text_settings(command, &asked);
    } else {
        command_text_scene(command, w->scene, &asked);
    }
    command_text_pair(command, pair);
    if (args->ordered)
        text_add(command, " --ordered");
    if (w->steps > 0)
        text_add(command, " --steps %u", w->steps);
}

static bool put_in_order(const duet_tune_def *def, duet_scene *scene, duet_error *err)
{
    uint32_t *ids = NULL;
    bool ok = !def->ordered || inputs_put_in_order(scene, def->pair, &ids, err);
    duet_free(ids);
    return ok;
}

// A tune file's variants for still steps are not for its queries and tasks, and its levels are not
// for its motions.
static void aim_at(duet_tune_def *def, const config_workload *w, bool from_file)
{
    def->query = w->query;
    def->items = w->items;
    def->steps = w->steps;
    if (!from_file || !(w->query || w->steps || w->task))
        return;
    def->n_levels = 0;
    def->has_accuracy = false;
    if (w->steps)
        return;
    def->search = NULL;
    def->n_variants = def->n_modes = 0;
}

static bool check_query(const config_workload *w, const duet_device_pair *pair, duet_error *err)
{
    return !w->query || !duet_device_pair_is_one(pair) ||
           bad_argument(err,
                        "query '%s': %s is one device and has no share to search; expected --pair "
                        "with two, or halves",
                        w->query, duet_device_pair_get_info(pair, 0)->selector);
}

static bool check_strategy(const arguments *args, const duet_device_pair *pair, duet_error *err)
{
    if (args->strategy && !strategy_check(args->strategy, err))
        return false;
    return !duet_device_pair_is_one(pair) || (!args->strategy && !args->strategy_path) ||
           bad_argument(err,
                        "--strategy%s: %s is one device and has no share to search; expected "
                        "--pair with two, or halves",
                        args->strategy ? "" : "-lua", duet_device_pair_get_info(pair, 0)->selector);
}

static bool tune_loaded(const arguments *args, duet_tune_def *def, const config_workload *w,
                        tune_report *report, duet_error *err)
{
    duet_tune_outcome outcome;
    text command = {0};
    aim_at(def, w, args->config);
    tune_report_workload(report, def);
    if (!duet_tune_run(def, &outcome, err))
        return false;
    begin_command(&command, args, w, def->pair);
    tune_report_add(report, &outcome, &command);
    text_free(&command);
    return true;
}

static bool tune_workload(const arguments *args, const duet_tune_def *tuning,
                          const config_workload *w, tune_report *report, duet_error *err)
{
    scene_options asked = options_of(args, w);
    duet_tune_def def = *tuning;
    duet_scene *scene = w->task ? NULL : inputs_load_objects(w->scene, &asked, err);
    def.task = w->task ? inputs_load_task(w->task, &asked, err) : NULL;
    def.scene = scene;
    bool ok = (scene || def.task) && check_query(w, def.pair, err) &&
              (!scene || put_in_order(&def, scene, err)) && tune_loaded(args, &def, w, report, err);
    duet_scene_destroy(scene);
    task_destroy(def.task);
    return ok;
}

static bool tune_workloads(const arguments *args, const tune_config *config, tune_report *report,
                           duet_error *err)
{
    duet_tune_def def = make_def(args, config, report);
    def.pair = inputs_open_pair(config->pair, err);
    bool ok = def.pair && check_strategy(args, def.pair, err);
    if (ok)
        tune_report_expect(report, def.pair, config->n_workloads, config->def.budget_seconds);
    for (uint32_t i = 0; ok && i < config->n_workloads; ++i)
        ok = tune_workload(args, &def, &config->workloads[i], report, err);
    duet_device_pair_destroy(def.pair);
    return ok;
}

static bool replay(const arguments *args, const char *scene, duet_error *err)
{
    number_list numbers = {.n = 0};
    return (!args->numbers || read_numbers(args->numbers, &numbers, err)) &&
           tune_replay(args, scene, &numbers, err);
}

static bool run(void *given, char **operands, duet_error *err)
{
    arguments *args = given;
    if (args->replay)
        return replay(args, operands[0], err);
    tune_config *config = calloc(1, sizeof *config);
    if (!config)
        return no_memory(err, "a tuning");
    tune_config_begin(config);
    tune_report report = tune_report_begin(args->json, args->store);
    bool ok =
        make_config(args, operands[0], config, err) && tune_workloads(args, config, &report, err);
    ok = tune_report_end(&report, ok, ok ? err : NULL) && ok;
    tune_config_free(config);
    free(config);
    return ok;
}

SUBCOMMAND(tune, .scene = SCENE_OPTIONS_DEFAULT, .level = LEVEL_OPTIONS_DEFAULT, .wait_seconds = -1)
