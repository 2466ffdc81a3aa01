// SPDX-License-Identifier: MIT
// duet source: the exact text of a kernel, what it lets vary, and whether a
// device's compiler takes all of it.
#define _POSIX_C_SOURCE 200809L
#include "cli/commands/source.h"
#include "base/error.h"
#include "base/nearest.h"
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/report/json.h"
#include "cli/say.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/opencl/program.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct arguments {
    option_list settings;
    const char *scene;
    const char *device;
    bool list;
    bool check;
    bool json;
    source_sample sample;
} arguments;

static const option options[] = {
    OPTION_SETTINGS("set", settings, "K=V", "a parameter of the kernel; may be repeated"),
    OPTION_TEXT("scene", scene, "SCENE", "set what the scene compiles in: DIMS, SHAPE, ROTATED"),
    OPTION_TEXT("device", device, "D", "use defaults and limits of this device (a small GPU)"),
    OPTION_FLAG("list", list, "list the kernels, their parameters and how many configs are valid"),
    OPTION_FLAG("check", check, "compile the valid configs on the device (else B of the pair)"),
    OPTION_COUNT("most", sample.most, "N", "compile at most N configs a kernel (32; 0: all)", 0, 0),
    OPTION_COUNT("seed", sample.seed, "S", "seed that chooses them, if there are more (1)", 0, 0),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {
    {"check set scene", OPTION_EXCLUDES, "list"},
    {"set scene", OPTION_EXCLUDES, "check"},
    {"most seed", OPTION_NEEDS, "check"},
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    bool prints = !args->list && !args->check;
    return prints && !operands[0] ? "KERNEL is missing; 'duet source --list' lists them" : NULL;
}

static const command_line line = {
    .name = "source",
    .operands = "[KERNEL]",
    .about = "Prints the exact text of a kernel as it is compiled. Parameters that are not\n"
             "set take the default of the kernel's card.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

// ---------------------------------------------------------------- one text

// Settings of a scene and of the command line.
typedef struct settings {
    gen_setting at[OPTION_LIST_MOST + 8];
    uint32_t n;
} settings;

// "WG=128"
static bool read_setting(const option_setting *given, settings *s, duet_error *err)
{
    char *end = NULL;
    errno = 0;
    int64_t value = strtoll(given->value, &end, 10);
    if (*given->value == '\0' || *end != '\0' || errno != 0)
        return bad_argument(err, "--set '%s': give a whole number, as WG=64", given->written);
    s->at[s->n++] = (gen_setting){given->name, value};
    return true;
}

static bool has_param(const gen_param *params, uint32_t n, const char *name)
{
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, name) == 0)
            return true;
    return false;
}

// Sets the parameters of the kernel that a scene decides.
static bool add_scene(gen *g, const char *name, const gen_limits *limits, const char *path,
                      settings *s, duet_error *err)
{
    const scene_options as_it_is = SCENE_OPTIONS_DEFAULT;
    const gen_param *params = NULL;
    uint32_t n = 0;
    if (!gen_params(g, name, limits, &params, &n, err))
        return false;
    duet_scene *scene = inputs_load_scene(path, &as_it_is, err);
    if (!scene)
        return false;
    const duet_scene_info *info = duet_scene_get_info(scene);
    const gen_setting decided[] = {
        {"DIMS", info->dims},
        {"SHAPE", info->shape},
        {"ROTATED", info->shape != DUET_SHAPE_BOUNDS && info->rotated},
        {"ORIGIN", origin_setting(info->origin_edge)},
    };
    for (size_t i = 0; i < sizeof decided / sizeof decided[0]; ++i)
        if (has_param(params, n, decided[i].name))
            s->at[s->n++] = decided[i];
    duet_scene_destroy(scene);
    return true;
}

static bool gather_settings(gen *g, const char *name, const gen_limits *limits,
                            const arguments *args, settings *s, duet_error *err)
{
    bool ok = !args->scene || add_scene(g, name, limits, args->scene, s, err);
    for (uint32_t i = 0; ok && i < args->settings.n; ++i)
        ok = read_setting(&args->settings.items[i], s, err);
    return ok;
}

static bool print_json(const gen_variant *v, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("variant", v->name), STRING("sha256", v->sha256), NUMBER("group", v->group),
             NUMBER("per_item", v->per_item), STRING("text", v->text));
    return say_json(o, err);
}

// To a file or a pipe as it is: its bytes are the variant's key.
static void print_text(const char *source)
{
    if (isatty(STDOUT_FILENO))
        say_lines(source);
    else
        fputs(source, stdout);
}

static bool print_source(gen *g, const char *name, const gen_limits *limits, const arguments *args,
                         duet_error *err)
{
    settings s = {.n = 0};
    gen_variant v = {0};
    bool ok = gather_settings(g, name, limits, args, &s, err);
    ok = ok && gen_make(g, name, s.at, s.n, limits, &v, err);
    if (ok && args->json)
        ok = print_json(&v, err);
    else if (ok)
        print_text(v.text);
    gen_variant_free(&v);
    return ok;
}

// ---------------------------------------------------------------- the command

// The least that OpenCL 1.2 asks for and GPUs have.
static const gen_limits small_gpu = {.max_group = 256, .local_bytes = 32 << 10, .fp64 = true};

// The device that was named, or else B of the default pair.
static bool open_device(const char *selector, device *d, duet_error *err)
{
    if (selector)
        return device_open(d, selector, err);
    duet_device_pair *pair = inputs_open_pair(NULL, err);
    bool ok = pair && device_open(d, duet_device_pair_get_info(pair, 1)->selector, err);
    duet_device_pair_destroy(pair);
    return ok;
}

static bool check_name(gen *g, const char *name, duet_error *err)
{
    nearest n = nearest_begin(name);
    for (uint32_t i = 0; gen_kernel(g, i); ++i) {
        if (strcmp(gen_kernel(g, i), name) == 0)
            return true;
        nearest_try(&n, gen_kernel(g, i));
    }
    if (n.name)
        return bad_argument(err, "no kernel '%s'; did you mean '%s'?", name, n.name);
    return bad_argument(err, "no kernel '%s'; 'duet source --list' lists those there are", name);
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    const char *only = operands[0];
    device d = {0};
    gen_limits limits = small_gpu;
    gen *g = gen_open(duet_default_device_pair_def().kernel_dir, err);
    bool ok = g && (!only || check_name(g, only, err));
    if (ok && (args->device || args->check)) {
        ok = open_device(args->device, &d, err);
        limits = program_limits(&d.info);
    }
    if (ok && args->list)
        ok = source_list(g, only, &limits, args->json, err);
    else if (ok && args->check)
        ok = source_check(g, &d, only, &args->sample, args->json, err);
    else if (ok)
        ok = print_source(g, only, &limits, args, err);
    device_close(&d);
    gen_close(g);
    return ok;
}

SUBCOMMAND(source, .sample = {.most = 32, .seed = 1})
