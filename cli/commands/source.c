// SPDX-License-Identifier: MIT
// duet source: the exact text of a kernel, what it lets vary, and whether a
// device's compiler takes all of it.
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/nearest.h"
#include "base/rng.h"
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/opencl/program.h"

#include <errno.h>
#include <inttypes.h>
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
    uint64_t most;
    uint64_t seed;
} arguments;

static const option options[] = {
    OPTION_SETTINGS("set", settings, "K=V", "a parameter of the kernel; may be repeated"),
    OPTION_TEXT("scene", scene, "SCENE", "what the scene compiles in: DIMS, SHAPE, ROTATED"),
    OPTION_TEXT("device", device, "D", "defaults and limits of this device; else a small GPU's"),
    OPTION_FLAG("list", list, "the kernels, what they let vary and how many configs are valid"),
    OPTION_FLAG("check", check, "compile the valid configs on the device (else B of the pair)"),
    OPTION_COUNT("most", most, "N", "configs a kernel that --check compiles (32; 0: all)", 0, 0),
    OPTION_COUNT("seed", seed, "S", "which ones, where there are more (1)", 0, 0),
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
    .most_operands = 1,
    .about = "Prints the exact text of a kernel as it is compiled. Parameters that are not\n"
             "set take the default of the kernel's card.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

// ---------------------------------------------------------------- one text

// Settings of a scene and of the command line, with space for their names.
typedef struct settings {
    gen_setting at[OPTION_LIST_MOST + 8];
    char names[OPTION_LIST_MOST][48];
    uint32_t n;
} settings;

// "WG=128"
static bool read_setting(const char *chars, settings *s, uint32_t i, duet_error *err)
{
    const char *equals = strchr(chars, '=');
    char *end = NULL;
    errno = 0;
    int64_t value = strtoll(equals + 1, &end, 10);
    if (equals[1] == '\0' || *end != '\0' || errno != 0)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "--set '%s': give a whole number, as WG=64",
                         chars);
    snprintf(s->names[i], sizeof s->names[i], "%.*s", (int)(equals - chars), chars);
    s->at[s->n++] = (gen_setting){s->names[i], value};
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
        ok = read_setting(args->settings.items[i], s, i, err);
    return ok;
}

static bool print_json(const gen_variant *v, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "variant", v->name);
    cJSON_AddStringToObject(o, "sha256", v->sha256);
    cJSON_AddNumberToObject(o, "group", v->group);
    cJSON_AddNumberToObject(o, "per_item", v->per_item);
    cJSON_AddStringToObject(o, "text", v->text);
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

// ---------------------------------------------------------------- --list

typedef struct listed {
    const char *name;
    const char *about;
    const gen_param *params;
    uint32_t n_params;
    uint64_t configs;
} listed;

static bool ask(gen *g, const char *name, const gen_limits *limits, listed *k, duet_error *err)
{
    k->name = name;
    return gen_about(g, name, &k->about, err) && gen_count(g, name, limits, &k->configs, err) &&
           gen_params(g, name, limits, &k->params, &k->n_params, err);
}

// "1 64 [128] 256", the default in brackets; "0 .. 31 [0]" for a range.
static void add_values(const gen_param *p, text *out)
{
    if (p->is_range)
        text_add(out, "%" PRId64 " .. %" PRId64 " [%" PRId64 "]", p->least, p->most, p->fallback);
    for (uint32_t i = 0; !p->is_range && i < p->n_values; ++i)
        text_add(out, p->values[i] == p->fallback ? "%s[%" PRId64 "]" : "%s%" PRId64, i ? " " : "",
                 p->values[i]);
}

static bool print_kernel(const listed *k, duet_error *err)
{
    printf("%s  %s\n", k->name, k->about);
    table t = table_begin("llll");
    text values = {0};
    for (uint32_t i = 0; i < k->n_params; ++i) {
        values.length = 0;
        add_values(&k->params[i], &values);
        table_words(&t, " ", k->params[i].name, text_chars(&values), k->params[i].about, NULL);
    }
    table_print(&t, stdout);
    printf("  %" PRIu64 " valid config%s\n\n", k->configs, k->configs == 1 ? "" : "s");
    bool ok = text_ok(&values, err);
    text_free(&values);
    return ok;
}

static void add_param(cJSON *list, const gen_param *p)
{
    cJSON *o = json_add_row(list);
    cJSON_AddStringToObject(o, "name", p->name);
    cJSON_AddStringToObject(o, "about", p->about);
    cJSON_AddNumberToObject(o, "default", (double)p->fallback);
    if (p->is_range) {
        cJSON_AddNumberToObject(o, "min", (double)p->least);
        cJSON_AddNumberToObject(o, "max", (double)p->most);
    }
    cJSON *values = cJSON_AddArrayToObject(o, "values");
    for (uint32_t i = 0; i < p->n_values; ++i)
        cJSON_AddItemToArray(values, cJSON_CreateNumber((double)p->values[i]));
}

static void add_kernel(cJSON *list, const listed *k)
{
    cJSON *o = json_add_row(list);
    cJSON_AddStringToObject(o, "name", k->name);
    cJSON_AddStringToObject(o, "about", k->about);
    cJSON_AddNumberToObject(o, "configs", (double)k->configs);
    cJSON *params = cJSON_AddArrayToObject(o, "params");
    for (uint32_t i = 0; i < k->n_params; ++i)
        add_param(params, &k->params[i]);
}

static bool list_kernels(gen *g, const char *only, const gen_limits *limits, const arguments *args,
                         duet_error *err)
{
    cJSON *o = args->json ? cJSON_CreateObject() : NULL;
    cJSON *kernels = o ? cJSON_AddArrayToObject(o, "kernels") : NULL;
    bool ok = true;
    const char *name = only ? only : gen_kernel(g, 0);
    for (uint32_t i = 0; ok && name; name = only ? NULL : gen_kernel(g, ++i)) {
        listed k;
        ok = ask(g, name, limits, &k, err);
        if (ok && o)
            add_kernel(kernels, &k);
        else if (ok)
            ok = print_kernel(&k, err);
    }
    if (ok && o)
        return say_json(o, err);
    cJSON_Delete(o);
    return ok;
}

// ---------------------------------------------------------------- --check

enum { PARAMS_MOST = 32 };

typedef struct checked {
    uint64_t configs;
    uint64_t compiled;
    uint64_t failed;
} checked;

// One from each of n equal parts of the space.
static uint64_t pick(rng *r, uint64_t part, uint64_t n, uint64_t configs)
{
    uint64_t from = part * configs / n;
    uint64_t to = (part + 1) * configs / n;
    return from + (to - from > 1 ? rng_below(r, (uint32_t)(to - from)) : 0);
}

static bool check_config(gen *g, program_set *set, const char *name, uint64_t index, checked *c,
                         duet_error *err)
{
    gen_setting config[PARAMS_MOST];
    const gen_param *params = NULL;
    uint32_t n = 0;
    gen_limits limits = program_set_limits(set);
    if (!gen_params(g, name, &limits, &params, &n, err) ||
        !gen_config(g, name, &limits, index, config, err))
        return false;
    duet_error why = {0};
    bool compiled = program_set_check(set, name, config, n, &why);
    if (!compiled && why.status != DUET_STATUS_BUILD_FAILED)
        return error_copy(err, &why);
    if (!compiled)
        fprintf(stderr, "duet: %s\n", why.text);
    c->compiled += compiled;
    c->failed += !compiled;
    return true;
}

static bool check_kernel(gen *g, program_set *set, const char *name, const arguments *args,
                         checked *c, duet_error *err)
{
    gen_limits limits = program_set_limits(set);
    rng r = rng_seed(args->seed);
    *c = (checked){0};
    if (!gen_count(g, name, &limits, &c->configs, err))
        return false;
    bool all = args->most == 0 || c->configs <= args->most;
    uint64_t n = all ? c->configs : args->most;
    progress p = progress_begin(name, n);
    bool ok = true;
    for (uint64_t i = 0; ok && i < n; ++i) {
        progress_show(&p, i);
        ok = interrupt_check(err);
        ok = ok && check_config(g, set, name, pick(&r, i, n, c->configs), c, err);
    }
    progress_end(&p);
    return ok;
}

static void print_checked(const char *name, const checked *c)
{
    printf("%-20s %" PRIu64 " of %" PRIu64 " configs compiled", name, c->compiled, c->configs);
    if (c->failed > 0)
        printf(", %" PRIu64 " failed", c->failed);
    putchar('\n');
}

static cJSON *checked_json(const char *name, const checked *c)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", name);
    cJSON_AddNumberToObject(o, "configs", (double)c->configs);
    cJSON_AddNumberToObject(o, "compiled", (double)c->compiled);
    cJSON_AddNumberToObject(o, "failed", (double)c->failed);
    return o;
}

static bool check_each(gen *g, program_set *set, const char *only, const arguments *args,
                       cJSON *kernels, uint64_t *failed, duet_error *err)
{
    const char *name = only ? only : gen_kernel(g, 0);
    for (uint32_t i = 0; name; name = only ? NULL : gen_kernel(g, ++i)) {
        checked c;
        if (!check_kernel(g, set, name, args, &c, err))
            return false;
        if (args->json)
            cJSON_AddItemToArray(kernels, checked_json(name, &c));
        else
            print_checked(name, &c);
        *failed += c.failed;
    }
    return true;
}

// Compiles valid configs on the device. Each that fails is a line on stderr;
// BUILD_FAILED with their number if there were some, INTERRUPTED on Ctrl-C.
static bool check_kernels(gen *g, const device *d, const char *only, const arguments *args,
                          duet_error *err)
{
    program_set *set = program_set_open(d, g, NULL, err);
    if (!set)
        return false;
    uint64_t failed = 0;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "device", d->info.selector);
    cJSON *kernels = cJSON_AddArrayToObject(o, "kernels");
    bool ok = check_each(g, set, only, args, kernels, &failed, err);
    program_set_close(set);
    if (ok && args->json)
        ok = say_json(o, err);
    else
        cJSON_Delete(o);
    if (ok && failed > 0)
        ok =
            error_set(err, DUET_STATUS_BUILD_FAILED, "%" PRIu64 " config%s failed to compile on %s",
                      failed, failed == 1 ? "" : "s", d->info.selector);
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
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "no kernel '%s'; did you mean '%s'?", name,
                         n.name);
    return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "no kernel '%s'; 'duet source --list' lists those there are", name);
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
        ok = list_kernels(g, only, &limits, args, err);
    else if (ok && args->check)
        ok = check_kernels(g, &d, only, args, err);
    else if (ok)
        ok = print_source(g, only, &limits, args, err);
    device_close(&d);
    gen_close(g);
    return ok;
}

int command_source(int argc, char **argv)
{
    arguments args = {.most = 32, .seed = 1};
    return options_run(&line, argc, argv, &args, run);
}
