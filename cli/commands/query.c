// SPDX-License-Identifier: MIT
// duet query: the narrow phase alone, on pairs that a file brings.
#include "base/error.h"
#include "base/npy.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    const char *level;
    const char *device;
    const char *pair;
    uint32_t share; // UINT32_MAX: not given
    const char *out;
    bool separations;
    bool json;
} arguments;

static const option options[] = {
    LEVEL_OPTION_ROW(level),
    OPTION_TEXT("device", device, "D", "use one device alone, as 'duet devices' names it"),
    PAIR_OPTION_ROW(pair),
    OPTION_SHARE("share", share, "R", "A's part of the pairs, such as 0.25 or 1/4"),
    OPTION_OUTPUT("output", out, "V.npy",
                  "write the answers: .npy as uint8, other endings as lines; - is stdout"),
    OPTION_FLAG("separations", separations,
                "write the separations along the best axis too, float64 as V.separations.npy"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {
    {"pair share", OPTION_EXCLUDES, "device"}, // which is one device alone
    {"separations", OPTION_NEEDS, "output"},
    {0},
};

static const command_line line = {
    .name = "query",
    .operands = "PAIRS.npy|FILE",
    .about = "Tests the pairs of a file as a step tests its candidates: 1 colliding, 0\n"
             "separated. A row is two poses of 10 numbers, centre xyz, half extents xyz,\n"
             "quaternion xyzw; in 2D two of 5, centre xy, half extents xy, angle. Files are\n"
             ".npy, or numbers as text.",
    .options = options,
    .rules = rules,
};

// ---------------------------------------------------------------- testing

typedef struct tested {
    duet_pair_query_def def;
    const char *path;
    const char *name; // the file's, or stdin
    const duet_pose *poses;
    uint64_t n; // pairs
    uint8_t *answers;
    double *separations; // NULL: not wanted
    uint64_t colliding, undecided;
    double seconds;
} tested;

// Pairs of a call: enough that progress and Ctrl-C between two calls cost nothing.
#define SLICE ((uint64_t)1 << 22)

// Drivers finish compiling at a kernel's first launch, which is not to be timed. There are enough
// pairs that each device with a share gets one.
static bool warm_up(tested *t, duet_pair_query *query, duet_error *err)
{
    duet_pair_query_result result;
    uint64_t n = t->n < DUET_SHARE_ONE ? t->n : DUET_SHARE_ONE;
    return duet_pair_query_run(query, t->poses, n, t->answers, NULL, &result, err);
}

static bool run_slices(tested *t, duet_pair_query *query, duet_error *err)
{
    progress shown = progress_begin("pair", t->n);
    bool ok = true;
    for (uint64_t done = 0; ok && done < t->n; done += SLICE) {
        duet_pair_query_result result;
        uint64_t left = t->n - done;
        ok = duet_pair_query_run(query, t->poses + 2 * done, left < SLICE ? left : SLICE,
                                 t->answers + done, t->separations ? t->separations + done : NULL,
                                 &result, err) &&
             interrupt_check(err);
        if (!ok)
            break;
        t->colliding += result.colliding;
        t->undecided += result.undecided;
        t->seconds += result.total_ms * 1e-3;
        progress_show(&shown, done);
    }
    progress_end(&shown);
    return ok;
}

static bool reserve(tested *t, bool separations, duet_error *err)
{
    t->answers = malloc(t->n + 1);
    t->separations = separations ? malloc((t->n + 1) * sizeof *t->separations) : NULL;
    return (t->answers && (t->separations || !separations)) ||
           no_memory(err, "the answers of %llu pairs of %s", (unsigned long long)t->n, t->path);
}

// ---------------------------------------------------------------- writing

static bool is_npy(const char *path)
{
    size_t length = strlen(path);
    return length >= 4 && strcmp(path + length - 4, ".npy") == 0;
}

static bool write_arrays(const tested *t, const char *path, duet_error *err)
{
    if (!npy_write(path, NPY_UINT8, t->answers, t->n, err))
        return false;
    if (!t->separations)
        return true;
    text beside = {0};
    text_add(&beside, "%.*s.separations.npy", (int)(strlen(path) - 4), path);
    bool ok =
        text_ok(&beside, err) && npy_write(beside.chars, NPY_FLOAT64, t->separations, t->n, err);
    text_free(&beside);
    return ok;
}

static bool write_lines(const tested *t, const char *path, duet_error *err)
{
    text lines = {0};
    for (uint64_t i = 0; i < t->n; ++i) {
        text_add(&lines, "%d", t->answers[i]);
        if (t->separations)
            text_add(&lines, ",%.17g", t->separations[i]);
        text_add(&lines, "\n");
    }
    return say_to_file(&lines, path, err);
}

// ---------------------------------------------------------------- telling

// As JSON, or by a script that is told a little more.
static bool tell(const tested *t, bool json, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("file", t->path), NUMBER("dims", t->def.dims),
             STRING("level", duet_level_get_info(t->def.level)->name));
    json_add_pair(o, "pair", t->def.pair);
    json_add(o, NUMBER("share", (double)t->def.share / DUET_SHARE_ONE), NUMBER("n", t->n),
             NUMBER("colliding", t->colliding), NUMBER("undecided", t->undecided),
             NUMBER("seconds", t->seconds));
    if (!json)
        json_add(o, STRING("name", t->name),
                 FLAG("one_device", duet_device_pair_is_one(t->def.pair)),
                 STRING("a", duet_device_pair_get_info(t->def.pair, 0)->selector),
                 STRING("b", duet_device_pair_get_info(t->def.pair, 1)->selector));
    return rendering_tell(o, json, "cli/report/query.lua", err);
}

// ---------------------------------------------------------------- the command

static duet_device_pair *open_devices(const arguments *args, duet_error *err)
{
    if (!args->device)
        return inputs_open_pair(args->pair, err);
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = def.b = args->device;
    return duet_device_pair_create(&def, err);
}

// One device is B, and A the same with nothing to do.
static uint32_t share_of(const arguments *args, const duet_device_pair *pair)
{
    if (args->device)
        return 0;
    return args->share == UINT32_MAX ? duet_default_plan(pair).share : args->share;
}

static bool run_test(tested *t, const arguments *args, duet_error *err)
{
    duet_pair_query *query = duet_pair_query_create(&t->def, err);
    bool ok = query && reserve(t, args->separations, err) && warm_up(t, query, err) &&
              run_slices(t, query, err);
    if (ok && args->out)
        ok = (is_npy(args->out) ? write_arrays : write_lines)(t, args->out, err);
    if (args->json || !options_is_stdout(args->out))
        ok = ok && tell(t, args->json, err);
    free(t->separations);
    free(t->answers);
    duet_pair_query_destroy(query);
    return ok;
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    const char *path = operands[0];
    duet_level level;
    if (!inputs_read_level(args->level, &level, err))
        return false;
    duet_device_pair *pair = open_devices(args, err);
    duet_scene *pairs = pair ? inputs_load_pairs(path, err) : NULL;
    bool ok = false;
    if (pairs) {
        const duet_scene_info *info = duet_scene_get_info(pairs);
        tested t = {.def = duet_default_pair_query_def(), .path = path, .name = info->name};
        t.def.pair = pair;
        t.def.share = share_of(args, pair);
        t.def.level = level;
        t.def.dims = info->dims;
        t.poses = duet_scene_get_objects(pairs, DUET_OBJECT_POSES);
        t.n = info->n / 2;
        ok = run_test(&t, args, err);
    }
    duet_scene_destroy(pairs);
    duet_device_pair_destroy(pair);
    return ok;
}

SUBCOMMAND(query, .share = UINT32_MAX)
