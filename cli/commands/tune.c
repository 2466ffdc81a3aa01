// SPDX-License-Identifier: MIT
// duet tune: finds how two devices share a scene's work best, and stores it.
//
// Each number of objects is a workload of its own. Ctrl-C keeps what was
// measured, and the same command goes on from there.
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "tuner/measure.h"
#include "tuner/tune_config.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_NUMBERS = 64 };

typedef struct arguments {
    scene_options scene;
    const char *config;
    const char *numbers;
    const char *pair;
    const char *strategy;
    const char *strategy_path;
    const char *search;
    const char *variants;
    level_options level;
    double budget_seconds;
    uint64_t budget_trials;
    uint64_t repeats;
    const char *store;
    bool fresh;
    bool keep;
    bool json;
} arguments;

static const option options[] = {
    OPTION_TEXT("config", config, "FILE", "a tune.lua: workloads, strategy, budget, variants"),
    OPTION_TEXT("objects", numbers, "LIST", "numbers of objects, with commas between them"),
    OPTION_COUNT("seed", scene.seed, "S", "seed of the scene's random numbers", 0, UINT32_MAX),
    OPTION_SETTINGS("set", scene.settings, "K=V", "any other parameter of the scene"),
    PAIR_OPTION_ROW(pair),
    OPTION_TEXT("strategy", strategy, "S",
                "how the share is searched: balance (default), fig12, grid, chunks"),
    OPTION_TEXT("strategy-lua", strategy_path, "FILE",
                "a script that returns a function from the history to the next share"),
    OPTION_TEXT(
        "variants", variants, "LIST",
        "kernels to choose from, with commas between them (auto,simd,auto sort=radix,paper)"),
    OPTION_TEXT("search", search, "WHAT",
                "search parameters too: 'kernels' for those of all kernels, or one kernel's name"),
    OPTION_TEXT("level", level.level, "LIST",
                "of accuracy, or several to choose from (the scene's; all, where how much may be "
                "wrong is given)"),
    ACCURACY_OPTION_ROWS(level),
    OPTION_NUMBER("budget", budget_seconds, "SECONDS", "time for each workload (no limit)", 0.001,
                  0),
    OPTION_COUNT("trials", budget_trials, "K", "trials for each workload (no limit)", 1,
                 UINT32_MAX),
    OPTION_COUNT("repeat", repeats, "K", "launches of a trial, after one to warm up (3)", 1, 32),
    OPTION_TEXT("profile", store, "FILE", "the profile file (DUET_PROFILE, or the user's own)"),
    OPTION_FLAG("fresh", fresh, "measure again what was asked and finished before"),
    OPTION_FLAG("keep", keep, "applications load what a strategy other than balance found, too"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "tune",
    .operands = "[SCENE|FILE]",
    .least_operands = 0,
    .most_operands = 1,
    .about = "Finds the kernels, the mode and the share with which two devices do a scene's work\n"
             "best, and keeps them in the profile file for 'duet run' and for applications.\n"
             "With --config the scenes are those of the file, and options go before its fields.\n"
             "A profile that applications load is replaced only by one that is founded as well.",
    .options = options,
};

// ---------------------------------------------------------------- lists

// "1000,2000" as numbers.
static bool read_numbers(const char *list, int64_t *numbers, uint32_t *n, duet_error *err)
{
    *n = 0;
    for (const char *at = list; *at || *n == 0;) {
        uint64_t number;
        const char *end = options_read_count(at, &number);
        if (!end || number > UINT32_MAX || (*end != ',' && *end != '\0') ||
            (*end == ',' && !end[1]) || *n == MOST_NUMBERS)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "--objects '%s': give up to %d numbers with commas between them, as "
                             "250000,500000",
                             list, MOST_NUMBERS);
        numbers[(*n)++] = (int64_t)number;
        at = *end == ',' ? end + 1 : end;
    }
    return true;
}

// Cuts a copy of the list at its commas; a variant may hold spaces.
static bool cut_variants(tune_config *config, const char *list, duet_error *err)
{
    config->n_variants = 0;
    text_add(&config->list, "%s", list);
    if (!text_ok(&config->list, err))
        return false;
    for (char *at = config->list.chars; at;) {
        if (config->n_variants == CONFIG_VARIANTS)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT, "--variants: at most %d",
                             CONFIG_VARIANTS);
        config->variants[config->n_variants++] = at;
        at = strchr(at, ',');
        if (at)
            *at++ = '\0';
    }
    return true;
}

// "sat6,sat15" as levels.
static bool read_levels(const char *list, tune_config *config, duet_error *err)
{
    config->n_levels = 0;
    for (const char *at = list; at;) {
        char name[32];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ","), at);
        if (config->n_levels == DUET_LEVELS)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT, "--level: at most %d levels",
                             DUET_LEVELS);
        if (!inputs_read_level(name, &config->levels[config->n_levels++], err))
            return false;
        const char *comma = strchr(at, ',');
        at = comma ? comma + 1 : NULL;
    }
    return true;
}

// What is given on the command line is all that is asked for.
static bool change_levels(const level_options *asked, tune_config *config, duet_error *err)
{
    duet_accuracy accuracy;
    bool given = inputs_accuracy_given(asked, &accuracy);
    if (!given && !asked->level)
        return true;
    config->n_levels = 0;
    config->has_accuracy = given;
    config->accuracy = accuracy;
    if (asked->level && !read_levels(asked->level, config, err))
        return false;
    return config->n_levels < 2 || given ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "--level %s: to choose one of several, give --missed or --false-rate",
                     asked->level);
}

// ---------------------------------------------------------------- config

static bool add_scene(const arguments *args, const char *path, tune_config *config, duet_error *err)
{
    int64_t numbers[MOST_NUMBERS] = {-1};
    uint32_t n = 1;
    if (args->numbers && !read_numbers(args->numbers, numbers, &n, err))
        return false;
    config->n_workloads = n;
    for (uint32_t i = 0; i < n; ++i)
        config->workloads[i] = (config_workload){.scene = path, .n = numbers[i]};
    return true;
}

static bool check_operands(const arguments *args, const char *path, duet_error *err)
{
    if (!path == !args->config)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "tune: give a scene, or a tune file with --config");
    if (args->config && args->numbers)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "--objects: with --config the file says how many");
    return true;
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
        config->strategy = args->strategy;
        config->strategy_lua = NULL;
    }
    if (args->strategy_path) {
        config->strategy = "lua";
        text_free(&config->text);
        if (!text_read_file(&config->text, args->strategy_path, err))
            return false;
        config->strategy_lua = text_chars(&config->text);
    }
    config->search = args->search ? args->search : config->search;
    config->pair = args->pair ? args->pair : config->pair;
    config->budget_seconds =
        args->budget_seconds > 0 ? args->budget_seconds : config->budget_seconds;
    config->budget_trials =
        args->budget_trials > 0 ? (uint32_t)args->budget_trials : config->budget_trials;
    config->repeats = args->repeats > 0 ? (uint32_t)args->repeats : config->repeats;
    if (!change_levels(&args->level, config, err))
        return false;
    return !args->variants || cut_variants(config, args->variants, err);
}

// ---------------------------------------------------------------- what is told

// A line while it measures, a row for each workload, and at the end what the shares
// are worth. The rows are kept as the JSON that --json prints; the table reads them back.
typedef struct tune_report {
    struct cJSON *workloads; // one object each
    char name[168];          // of the workload that is measured
    uint32_t number;         // of it, from 1
    uint32_t n_workloads;
    char whole[80]; // the device that A and B may be parts of
    bool one;       // A and B are the same device
    double budget_seconds;
    bool json;
    bool on_terminal;
} tune_report;

static tune_report report_begin(bool json)
{
    return (tune_report){
        .workloads = cJSON_CreateArray(), .json = json, .on_terminal = isatty(STDERR_FILENO)};
}

static void report_workload(tune_report *r, const duet_scene_info *scene)
{
    snprintf(r->name, sizeof r->name, "%.30s, %s", scene->name, table_count(scene->n).chars);
    ++r->number;
}

static void clear_line(const tune_report *r)
{
    if (r->on_terminal)
        fprintf(stderr, "\r\033[K");
}

// At most, by the trials or the time that are left; below 0 where nothing bounds it.
static double seconds_left(const tune_report *r, const duet_tune_progress *p)
{
    double by_time = r->budget_seconds > 0 ? fmax(r->budget_seconds - p->seconds, 0) : -1;
    if (p->trials == 0 || p->most_trials < p->trials)
        return by_time;
    double by_trials = p->seconds / p->trials * (p->most_trials - p->trials);
    return by_time < 0 ? by_trials : fmin(by_time, by_trials);
}

static void write_progress(const tune_report *r, const duet_tune_progress *p, text *shown)
{
    double left = seconds_left(r, p);
    text_add(shown, "%u/%u %.22s: %s", r->number, r->n_workloads, r->name, p->stage);
    if (p->trials == 0) {
        text_add(shown, ", step %u, %.1f s", p->launches, p->seconds);
        return;
    }
    text_add(shown, " %.4f %s, trial %u", p->plan->share / (double)DUET_SHARE_ONE,
             duet_mode_name(p->plan->mode), p->trials);
    if (p->most_trials > 0)
        text_add(shown, " of %u", p->most_trials);
    if (left >= 0)
        text_add(shown, ", %.0f s left", left);
    text_add(shown, "%s", p->remembered ? " (known)" : "");
}

// A duet_tune_watch; stops after Ctrl-C.
static bool report_watch(void *report, const duet_tune_progress *p)
{
    enum { COLUMNS = 79 };
    const tune_report *r = report;
    if (r->on_terminal) {
        text shown = {0};
        write_progress(r, p, &shown);
        fprintf(stderr, "\r\033[K%.*s", COLUMNS, text_chars(&shown));
        text_free(&shown);
    }
    return !interrupt_asked();
}

static void add_terms(cJSON *o, const duet_tune_terms *t)
{
    cJSON *terms = cJSON_AddObjectToObject(o, "terms");
    for (const terms_field *f = terms_fields; f->name; ++f)
        cJSON_AddNumberToObject(terms, f->name, terms_value(f, t));
}

// What was searched of either device's kernels.
static void add_kernels(cJSON *row, const duet_tune_outcome *o)
{
    cJSON *list = cJSON_AddArrayToObject(row, "kernels");
    for (int device = 0; device < 2; ++device) {
        const duet_kernel_search *k = &o->kernels[device];
        if (k->configs == 0)
            continue;
        cJSON *one = cJSON_CreateObject();
        cJSON_AddStringToObject(one, "device", device == 0 ? "A" : "B");
        cJSON_AddStringToObject(one, "variant",
                                device == 0 ? o->plan.variant_a : o->plan.variant_b);
        cJSON_AddNumberToObject(one, "configs", k->configs);
        cJSON_AddNumberToObject(one, "tried", k->tried);
        cJSON_AddNumberToObject(one, "launches", k->launches);
        cJSON_AddNumberToObject(one, "gain", k->gain);
        cJSON_AddNumberToObject(one, "gain_low", k->gain_low);
        cJSON_AddNumberToObject(one, "gain_high", k->gain_high);
        cJSON_AddStringToObject(one, "verdict", k->verdict);
        cJSON_AddItemToArray(list, one);
    }
}

// Steps after which the time that tuning took is won back; 0 where it is not,
// or where it was not measured here.
static double break_even(const duet_tune_outcome *o)
{
    double won_ms = o->single_ms - o->step_ms;
    return won_ms > 0 ? ceil(o->seconds * 1e3 / won_ms) : 0;
}

static void report_add(tune_report *r, const duet_tune_outcome *o)
{
    cJSON *row = cJSON_CreateObject();
    cJSON_AddStringToObject(row, "workload", r->name);
    cJSON_AddNumberToObject(row, "objects", o->objects);
    cJSON_AddStringToObject(row, "level", duet_level_get_info(o->level)->name);
    cJSON_AddNumberToObject(row, "missed_rate", o->accuracy.missed);
    cJSON_AddNumberToObject(row, "false_rate", o->accuracy.false_rate);
    cJSON_AddNumberToObject(row, "true_pairs", (double)o->true_pairs);
    json_add_plan(row, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                  o->plan.variant_a, o->plan.variant_b);
    cJSON_AddBoolToObject(row, "one_device", r->one);
    cJSON_AddNumberToObject(row, "best_share", o->best.share / (double)DUET_SHARE_ONE);
    cJSON_AddNumberToObject(row, "gain", o->gain);
    cJSON_AddNumberToObject(row, "gain_low", o->gain_low);
    cJSON_AddNumberToObject(row, "gain_high", o->gain_high);
    cJSON_AddStringToObject(row, "verdict", o->verdict);
    cJSON_AddNumberToObject(row, "step_ms", o->step_ms);
    cJSON_AddNumberToObject(row, "rounds", o->rounds);
    cJSON_AddNumberToObject(row, "single_ms", o->single_ms);
    if (o->whole_ms > 0) {
        cJSON_AddStringToObject(row, "whole", r->whole);
        cJSON_AddNumberToObject(row, "whole_ms", o->whole_ms);
        cJSON_AddNumberToObject(row, "whole_gain", o->whole_gain);
        cJSON_AddNumberToObject(row, "whole_gain_low", o->whole_gain_low);
        cJSON_AddNumberToObject(row, "whole_gain_high", o->whole_gain_high);
    }
    cJSON_AddNumberToObject(row, "launches", o->launches);
    cJSON_AddNumberToObject(row, "seconds", o->seconds);
    cJSON_AddNumberToObject(row, "break_even_steps", break_even(o));
    cJSON_AddBoolToObject(row, "known", o->known);
    cJSON_AddBoolToObject(row, "resumed", o->resumed);
    cJSON_AddStringToObject(row, "uid", o->uid);
    cJSON_AddStringToObject(row, "unused", o->unused);
    add_terms(row, &o->terms);
    add_kernels(row, o);
    cJSON_AddItemToArray(r->workloads, row);
    clear_line(r);
}

// Certified needs no word: nothing of it is wrong.
static void print_accuracy(const cJSON *row)
{
    if (strcmp(json_string(row, "level"), "certified") == 0)
        return;
    printf("  of %s pairs that collide '%s' misses %.3g %% and invents %.3g %%\n",
           table_count((uint64_t)json_number(row, "true_pairs")).chars, json_string(row, "level"),
           100 * json_number(row, "missed_rate"), 100 * json_number(row, "false_rate"));
}

static void print_kernels(const cJSON *row)
{
    const cJSON *one;
    cJSON_ArrayForEach(one, json_list(row, "kernels"))
        printf("  kernels of %s: %.0f of %.0f configs tried in %.0f launches, %+.1f %% (%+.1f to "
               "%+.1f): %s; '%s'\n",
               json_string(one, "device"), json_number(one, "tried"), json_number(one, "configs"),
               json_number(one, "launches"), 100 * json_number(one, "gain"),
               100 * json_number(one, "gain_low"), 100 * json_number(one, "gain_high"),
               json_string(one, "verdict"), json_string(one, "variant"));
}

// The share as it is stored.
static uint32_t share_of(const cJSON *row)
{
    return (uint32_t)lround(json_number(row, "share") * DUET_SHARE_ONE);
}

static bool is_shared(const cJSON *row)
{
    return share_of(row) > 0 && share_of(row) < DUET_SHARE_ONE;
}

static void add_table_row(table *t, const cJSON *row)
{
    table_cell(t, "%.22s", json_string(row, "workload"));
    if (is_shared(row))
        table_cell(t, "A %.2f %%", 100 * json_number(row, "share"));
    else
        table_words(t,
                    json_true(row, "one_device") ? "one device"
                    : share_of(row) == 0         ? "B alone"
                                                 : "A alone",
                    NULL);
    table_cell(t, "%.3f", json_number(row, "step_ms"));
    if (is_shared(row)) {
        table_cell(t, "%+.1f", 100 * json_number(row, "gain"));
        table_cell(t, "%+.1f", 100 * json_number(row, "gain_low"));
        table_cell(t, "%+.1f", 100 * json_number(row, "gain_high"));
        table_words(t, json_string(row, "verdict"), NULL);
    } else {
        table_words(t, "-", "", "", "-", NULL);
    }
    table_cell(t, "%.1f", json_number(row, "seconds"));
}

static void print_variant(const char *name, const char *variant)
{
    bool has_space = strchr(variant, ' ');
    printf(" --%s %s%s%s", name, has_space ? "'" : "", variant, has_space ? "'" : "");
}

// The plan as options of 'duet run'.
static void print_plan(const cJSON *row)
{
    const char *a = json_string(row, "variant_a"), *b = json_string(row, "variant_b");
    printf("  --share %.5g --mode %s", json_number(row, "share"), json_string(row, "mode"));
    if (strcmp(a, b) == 0) {
        print_variant("variant", a);
    } else {
        print_variant("variant-a", a);
        print_variant("variant-b", b);
    }
    printf("\n");
}

// Why a plan is not loaded, and what would change that.
static void print_use(const cJSON *row)
{
    const char *unused = json_string(row, "unused");
    if (!*unused)
        return;
    printf("  not used by applications: %s\n", unused);
    if (strcmp(json_string(row, "verdict"), "ambiguous") == 0)
        printf("  a larger --trials or --budget reaches a verdict\n");
    else
        printf("  'duet profiles use %.8s' makes them use it\n", json_string(row, "uid"));
}

// What the table has no column for.
static void print_details(const cJSON *row)
{
    printf("\n%s, level %s, %.0f launches\n", say_name(json_string(row, "workload")).chars,
           json_string(row, "level"), json_number(row, "launches"));
    print_plan(row);
    if (!is_shared(row) && !json_true(row, "one_device"))
        printf("  %s\n",
               table_gain(share_of(row), json_number(row, "gain"), json_number(row, "gain_low"),
                          json_number(row, "gain_high"), json_string(row, "verdict"))
                   .chars);
    if (json_number(row, "whole_ms") > 0)
        printf("  %s\n",
               table_whole(json_string(row, "whole"), json_number(row, "whole_gain"),
                           json_number(row, "whole_gain_low"), json_number(row, "whole_gain_high"))
                   .chars);
    print_accuracy(row);
    print_use(row);
    if (json_true(row, "known"))
        printf("  known: the same was measured before; --fresh measures it again\n");
    print_kernels(row);
}

static void print_table(const cJSON *workloads)
{
    table t = table_begin("llrrrrlr");
    table_words(&t, "workload", "plan", "ms", "gain %", "from", "to", "verdict", "seconds", NULL);
    const cJSON *row;
    cJSON_ArrayForEach(row, workloads) add_table_row(&t, row);
    table_print(&t, stdout);
    printf("plan: A's part of the work; B does the rest. ms: a step by this plan.\n"
           "gain: by how much it is faster than the better device alone; it lies between\n"
           "'from' and 'to' with 99 %% confidence.\n");
    cJSON_ArrayForEach(row, workloads) print_details(row);
}

// Prints the table, or the object. After a failure only the table, of what was
// done before.
static bool report_end(tune_report *r, bool ok, duet_error *err)
{
    clear_line(r);
    if (r->json && ok) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddItemToObject(o, "workloads", r->workloads);
        return say_json(o, err);
    }
    if (!r->json && cJSON_GetArraySize(r->workloads) > 0)
        print_table(r->workloads);
    cJSON_Delete(r->workloads);
    return true;
}

// ---------------------------------------------------------------- workloads

static duet_tune_def make_def(const arguments *args, const tune_config *config, tune_report *report)
{
    duet_tune_def def = duet_default_tune_def();
    def.store = args->store;
    def.fresh = args->fresh;
    def.keep = args->keep ? DUET_KEEP_ALWAYS : DUET_KEEP_DEFAULT;
    def.strategy = config->strategy ? config->strategy : def.strategy;
    def.strategy_lua = config->strategy_lua;
    def.script = args->config ? text_chars(&config->text) : NULL;
    def.search = config->search;
    def.variants = config->variants;
    def.n_variants = config->n_variants;
    def.modes = config->modes;
    def.n_modes = config->n_modes;
    def.levels = config->levels;
    def.n_levels = config->n_levels;
    def.has_accuracy = config->has_accuracy;
    def.accuracy = config->accuracy;
    def.budget_seconds = config->budget_seconds;
    def.budget_trials = config->budget_trials;
    def.repeats = config->repeats;
    def.seed = config->seed;
    def.watch = report_watch;
    def.watch_context = report;
    return def;
}

static duet_scene *load_scene(const arguments *args, const config_workload *w, duet_error *err)
{
    scene_options scene = args->scene;
    scene.n = w->n < 0 ? UINT64_MAX : (uint64_t)w->n;
    for (uint32_t i = 0; i < w->n_settings && scene.settings.n < OPTION_LIST_MOST; ++i)
        scene.settings.items[scene.settings.n++] = w->settings[i];
    return inputs_load_scene(w->scene, &scene, err);
}

static bool tune_workload(duet_tune_def *def, const duet_scene *scene, tune_report *report,
                          duet_error *err)
{
    duet_tune_outcome outcome;
    def->scene = scene;
    report_workload(report, duet_scene_get_info(scene));
    if (!duet_tune_run(def, &outcome, err))
        return false;
    report_add(report, &outcome);
    return true;
}

static bool tune_workloads(const arguments *args, const tune_config *config, tune_report *report,
                           duet_error *err)
{
    duet_tune_def def = make_def(args, config, report);
    def.pair = inputs_open_pair(config->pair, err);
    bool ok = def.pair;
    report->n_workloads = config->n_workloads;
    report->budget_seconds = config->budget_seconds;
    if (ok) {
        report->one = strcmp(duet_device_pair_get_info(def.pair, 0)->selector,
                             duet_device_pair_get_info(def.pair, 1)->selector) == 0;
        snprintf(report->whole, sizeof report->whole, "%.*s",
                 (int)strcspn(duet_device_pair_get_info(def.pair, 0)->selector, "["),
                 duet_device_pair_get_info(def.pair, 0)->selector);
    }
    for (uint32_t i = 0; ok && i < config->n_workloads; ++i) {
        duet_scene *scene = load_scene(args, &config->workloads[i], err);
        ok = scene && tune_workload(&def, scene, report, err);
        duet_scene_destroy(scene);
    }
    duet_device_pair_destroy(def.pair);
    return ok;
}

static bool run(void *given, char **operands, duet_error *err)
{
    arguments *args = given;
    tune_config *config = calloc(1, sizeof *config);
    if (!config)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a tuning");
    tune_report report = report_begin(args->json);
    bool ok =
        make_config(args, operands[0], config, err) && tune_workloads(args, config, &report, err);
    ok = report_end(&report, ok, ok ? err : NULL) && ok;
    tune_config_free(config);
    free(config);
    return ok;
}

int command_tune(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .level = LEVEL_OPTIONS_DEFAULT};
    return options_run(&line, argc, argv, &args, run);
}
