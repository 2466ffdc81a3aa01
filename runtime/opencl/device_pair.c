// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/opencl/device_pair.h"

#include "base/error.h"
#include "base/variable.h"
#include "runtime/duet_opencl.h"
#include "runtime/opencl/cache.h"
#include "runtime/opencl/device_list.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7001 };

typedef struct selector_pair {
    char a[80];
    char b[80];
} selector_pair;

duet_device_pair_def duet_default_device_pair_def(void)
{
    const char *cache = variable_text("DUET_CACHE");
    return (duet_device_pair_def){
        .a = variable_text("DUET_PAIR"),
        .kernel_dir = variable_text("DUET_KERNEL_DIR"),
        .cache_dir = cache && strcmp(cache, "off") == 0 ? "" : cache,
        .cookie = COOKIE,
    };
}

static void name_both(selector_pair *names, const device_root *a, const device_root *b)
{
    snprintf(names->a, sizeof names->a, "%s", a->info.selector);
    snprintf(names->b, sizeof names->b, "%s", b->info.selector);
}

// A CPU that cannot be cut, because it has one unit say, is both.
static bool name_halves(selector_pair *names, duet_error *err)
{
    const device_root *cpu = device_list_strongest(DEVICE_CPU, NULL);
    if (!cpu)
        return error_set(err, DUET_STATUS_NO_DEVICE,
                         "halves: there is no CPU to cut; to work on it: apt install "
                         "pocl-opencl-icd");
    name_both(names, cpu, cpu);
    if (cpu->info.can_cut) {
        snprintf(names->a, sizeof names->a, "%s[1/2]", cpu->info.selector);
        snprintf(names->b, sizeof names->b, "%s[2/2]", cpu->info.selector);
    }
    return true;
}

// Two CPU devices are two views of the same cores, so one of them works alone; without a
// CPU the two strongest devices share the work.
static void choose(selector_pair *names)
{
    const device_root *cpu = device_list_strongest(DEVICE_CPU, NULL);
    const device_root *first = device_list_strongest(DEVICE_NO_CPU, NULL);
    const device_root *second = device_list_strongest(DEVICE_NO_CPU, first);
    if (cpu)
        name_both(names, cpu, first ? first : cpu);
    else
        name_both(names, first, second ? second : first);
}

// "A,B", or one selector for both.
static bool cut_list(selector_pair *names, const char *list, duet_error *err)
{
    size_t a = strcspn(list, ",");
    const char *second = list[a] ? list + a + 1 : list;
    size_t b = strcspn(second, ",");
    bool halves = list[a] && strstr(list, "halves");
    if (a == 0 || b == 0 || second[b] || halves || a >= sizeof names->a || b >= sizeof names->b)
        return bad_argument(err,
                            "device pair '%s': expected two selectors with a comma between them, "
                            "as cpu,gpu, or one, or halves; 'duet devices' lists the devices",
                            list);
    snprintf(names->a, sizeof names->a, "%.*s", (int)a, list);
    snprintf(names->b, sizeof names->b, "%s", second);
    return true;
}

static bool open_devices(duet_device_pair *pair, const duet_device_pair_def *def, duet_error *err)
{
    selector_pair chosen = {0};
    const device_root *roots = NULL;
    uint32_t n = 0;
    if (!def->a && def->b)
        return bad_argument(
            err, "a device pair has B '%s' and no A; expected both, A alone, or none", def->b);
    if (!device_list_roots(&roots, &n, err))
        return false;
    if (!def->a)
        choose(&chosen);
    else if (!def->b && !(strcmp(def->a, "halves") == 0 ? name_halves(&chosen, err)
                                                        : cut_list(&chosen, def->a, err)))
        return false;
    return device_open(&pair->devices[0], *chosen.a ? chosen.a : def->a, err) &&
           device_open_beside(&pair->devices[1], *chosen.b ? chosen.b : def->b, &pair->devices[0],
                              err);
}

bool duet_device_pair_is_one(const duet_device_pair *pair)
{
    if (!pair)
        return false;
    const device *a = &pair->devices[0], *b = &pair->devices[1];
    bool alike = strcmp(a->info.selector, b->info.selector) == 0;
    return a->id == b->id || (alike && !a->callers && !b->callers);
}

// $XDG_CACHE_HOME/duet; NULL where there is no home.
static char *default_cache(void)
{
    const char *base = variable_text("XDG_CACHE_HOME");
    const char *home = variable_text("HOME");
    char path[4096];
    bool fits = false;
    if (base && *base == '/')
        fits = snprintf(path, sizeof path, "%s/duet", base) < (int)sizeof path;
    else if (home)
        fits = snprintf(path, sizeof path, "%s/.cache/duet", home) < (int)sizeof path;
    return fits ? strdup(path) : NULL;
}

static bool keep_folder(char **kept, const char *folder, duet_error *err)
{
    if (!folder || !*folder)
        return true;
    *kept = strdup(folder);
    return *kept || no_memory(err, "a device pair");
}

// All but the devices; NULL where that cannot be had.
static duet_device_pair *make_pair(const duet_device_pair_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "the def of a device pair begins with duet_default_device_pair_def");
    duet_device_pair *pair = calloc(1, sizeof *pair);
    if (!pair)
        return null_no_memory(err, "a device pair");
    device_pair_hold(pair);
    bool ok = keep_folder(&pair->kernel_dir, def->kernel_dir, err);
    ok = ok && keep_folder(&pair->cache_dir, def->cache_dir, err);
    ok = ok && (!pair->cache_dir || cache_check(pair->cache_dir, err));
    if (!def->cache_dir)
        pair->cache_dir = default_cache();
    pair->builder =
        (program_builder){pair->cache_dir, !def->cache_dir, def->on_compile, def->context};
    if (ok)
        return pair;
    duet_device_pair_destroy(pair);
    return NULL;
}

static duet_device_pair *keep_opened(duet_device_pair *pair, bool opened)
{
    if (opened)
        return pair;
    duet_device_pair_destroy(pair);
    return NULL;
}

duet_device_pair *duet_device_pair_create(const duet_device_pair_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_device_pair *pair = make_pair(def, err);
    return keep_opened(pair, pair && open_devices(pair, def, err));
}

duet_device_pair *duet_device_pair_open(const char *selectors, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = selectors ? selectors : def.a;
    return duet_device_pair_create(&def, err);
}

// A device without a queue is opened by its selector, or else is the other's.
static bool open_on(device *d, cl_command_queue own, const char *selector, cl_command_queue others,
                    duet_error *err)
{
    return !own && selector ? device_open(d, selector, err)
                            : device_open_on_queue(d, own ? own : others, err);
}

duet_device_pair *duet_device_pair_create_on_queues(const duet_device_pair_def *def,
                                                    cl_command_queue a, cl_command_queue b,
                                                    duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(a ? a : b, __func__, "queue", err))
        return NULL;
    duet_device_pair *pair = make_pair(def, err);
    return keep_opened(pair, pair && open_on(&pair->devices[0], a, def->a, b, err) &&
                                 open_on(&pair->devices[1], b, def->b, a, err));
}

bool duet_device_pair_check_cache(const duet_device_pair *pair, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(pair, __func__, "pair", err))
        return false;
    for (int i = 0; i < 2; ++i)
        if (program_builder_keeps(&pair->builder, &pair->devices[i].info))
            return cache_check_writable(pair->cache_dir, err);
    return true;
}

void device_pair_hold(duet_device_pair *pair)
{
    atomic_fetch_add(&pair->users, 1);
}

void duet_device_pair_destroy(duet_device_pair *pair)
{
    if (!pair || atomic_fetch_sub(&pair->users, 1) > 1)
        return;
    device_close(&pair->devices[1]);
    device_close(&pair->devices[0]);
    free(pair->cache_dir);
    free(pair->kernel_dir);
    free(pair);
}

const duet_device_info *duet_device_pair_get_info(const duet_device_pair *pair, int which)
{
    return pair && (which == 0 || which == 1) ? &pair->devices[which].info : NULL;
}
