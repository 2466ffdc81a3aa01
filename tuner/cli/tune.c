// SPDX-License-Identifier: MIT
// duet tune: finds how two devices share a scene's work best, and stores it.
//
// Each number of objects is a workload of its own. Ctrl-C keeps what was
// measured, and the same command goes on from there.
#include "runtime/base/error.h"
#include "runtime/base/text.h"
#include "tuner/cli/commands.h"
#include "tuner/cli/inputs.h"
#include "tuner/cli/interrupt.h"
#include "tuner/cli/options.h"
#include "tuner/cli/say.h"
#include "tuner/cli/tune_report.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NUMBERS = 64, MOST_VARIANTS = 32 };

typedef struct arguments {
    scene_options scene;
    const char *numbers;
    const char *pair;
    const char *strategy;
    const char *strategy_path;
    const char *variants;
    double budget_seconds;
    uint64_t budget_trials;
    uint64_t repeats;
    const char *store;
    bool fresh;
    bool json;
} arguments;

static const option options[] = {
    OPTION_TEXT("n", numbers, "LIST", "numbers of objects, with commas between them"),
    OPTION_COUNT("seed", scene.seed, "S", "seed of the scene's random numbers", 0, UINT32_MAX),
    OPTION_SETTINGS("set", scene.settings, "K=V", "any other parameter of the scene"),
    PAIR_OPTION_ROW(pair),
    OPTION_TEXT(
        "strategy", strategy, "S",
        "how the share is searched: balance (default), fig12, bisect, golden, grid, chunks"),
    OPTION_TEXT("strategy-lua", strategy_path, "FILE",
                "a script that returns a function from the history to the next share"),
    OPTION_TEXT("variants", variants, "LIST",
                "kernels to choose from, with commas between them (rows,rows sort=radix,paper)"),
    OPTION_NUMBER("budget", budget_seconds, "SECONDS", "time for each workload (no limit)", 0, 0),
    OPTION_COUNT("trials", budget_trials, "K", "trials for each workload (no limit)", 1,
                 UINT32_MAX),
    OPTION_COUNT("repeat", repeats, "K", "launches of a trial, after one to warm up (3)", 1, 32),
    OPTION_TEXT("store", store, "FILE", "the profile file (DUET_PROFILE, or the user's own)"),
    OPTION_FLAG("fresh", fresh, "measure again what is finished"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "tune",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Finds the kernels, the mode and the share with which two devices do a scene's work\n"
             "best, and keeps them in the profile file for 'duet run' and for applications.",
    .options = options,
};

// ---------------------------------------------------------------- lists

// "1000,2000" as numbers.
static bool read_numbers(const char *list, uint64_t *numbers, uint32_t *n, duet_error *err)
{
    *n = 0;
    for (const char *at = list; *at;) {
        char *end;
        uint64_t number = strtoull(at, &end, 10);
        bool is_number = end > at && *at >= '0' && *at <= '9' && number <= UINT32_MAX;
        if (!is_number || (*end != ',' && *end != '\0') || (*end == ',' && !end[1]) ||
            *n == MOST_NUMBERS)
            return error_set(err, DUET_BAD_ARGUMENT,
                             "--n '%s': give up to %d numbers with commas between them, as "
                             "250000,500000",
                             list, MOST_NUMBERS);
        numbers[(*n)++] = number;
        at = *end == ',' ? end + 1 : end;
    }
    return true;
}

// Cuts a copy of the list at its commas; a variant may hold spaces.
static bool cut_variants(text *copy, const char *list, const char **variants, uint32_t *n,
                         duet_error *err)
{
    text_add(copy, "%s", list);
    if (!text_ok(copy, err))
        return false;
    for (char *at = copy->chars; at; ++*n) {
        if (*n == MOST_VARIANTS)
            return error_set(err, DUET_BAD_ARGUMENT, "--variants: at most %d", MOST_VARIANTS);
        variants[*n] = at;
        at = strchr(at, ',');
        if (at)
            *at++ = '\0';
    }
    return true;
}

// ---------------------------------------------------------------- workloads

static bool tune_workload(const arguments *args, const char *path, duet_tune_def *def,
                          tune_report *report, duet_error *err)
{
    duet_tune_outcome outcome;
    duet_scene *scene = inputs_load_scene(path, &args->scene, err);
    if (!scene)
        return false;
    def->scene = scene;
    tune_report_workload(report, duet_scene_describe(scene));
    bool ok = duet_tune_run(def, &outcome, err);
    if (ok)
        tune_report_add(report, &outcome);
    duet_scene_destroy(scene);
    return ok;
}

static bool tune_workloads(arguments *args, const char *path, duet_tune_def *def,
                           tune_report *report, duet_error *err)
{
    uint64_t numbers[MOST_NUMBERS] = {UINT64_MAX};
    uint32_t n = 1;
    if (args->numbers && !read_numbers(args->numbers, numbers, &n, err))
        return false;
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        args->scene.n = numbers[i];
        ok = tune_workload(args, path, def, report, err);
    }
    return ok;
}

static bool fill_def(const arguments *args, duet_tune_def *def, text *script, text *variants,
                     const char **cut, duet_error *err)
{
    def->store = args->store;
    def->fresh = args->fresh;
    def->budget_seconds = args->budget_seconds;
    def->budget_trials = (uint32_t)args->budget_trials;
    def->repeats = (uint32_t)args->repeats;
    def->strategy = args->strategy ? args->strategy : def->strategy;
    def->variants = cut;
    if (args->strategy_path) {
        def->strategy = "lua";
        if (!text_read_file(script, args->strategy_path, err))
            return false;
        def->strategy_lua = text_chars(script);
    }
    return !args->variants || cut_variants(variants, args->variants, cut, &def->n_variants, err);
}

static bool tune(arguments *args, const char *path, duet_error *err)
{
    const char *cut[MOST_VARIANTS];
    text script = {0}, variants = {0};
    tune_report report = tune_report_begin(args->json);
    duet_tune_def def = duet_default_tune_def();
    def.watch = tune_report_watch;
    def.watch_context = &report;
    bool ok = fill_def(args, &def, &script, &variants, cut, err);
    def.pair = ok ? inputs_open_pair(args->pair, err) : NULL;
    ok = def.pair && tune_workloads(args, path, &def, &report, err);
    ok = tune_report_end(&report, ok ? err : NULL) && ok;
    duet_device_pair_close(def.pair);
    text_free(&script);
    text_free(&variants);
    return ok;
}

int command_tune(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return tune(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
