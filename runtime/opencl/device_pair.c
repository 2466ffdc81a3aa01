// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/opencl/device_pair.h"

#include "base/error.h"
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

// An empty variable is as if it were not set.
static const char *variable(const char *name)
{
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

duet_device_pair_def duet_default_device_pair_def(void)
{
    return (duet_device_pair_def){
        .kernel_dir = variable("DUET_KERNEL_DIR"),
        .cache_dir = variable("DUET_CACHE"),
        .cookie = COOKIE,
    };
}

static uint64_t strength(const duet_device_info *info)
{
    return (uint64_t)info->units * (info->clock_mhz ? info->clock_mhz : 1);
}

// The strongest CPU, or the strongest device that is none; NULL where there is
// none of that kind. What is passed over is not looked at.
static const duet_device_info *strongest(const device_root *roots, uint32_t n, bool cpu,
                                         const duet_device_info *passed_over)
{
    const duet_device_info *best = NULL;
    for (uint32_t i = 0; i < n; ++i) {
        const duet_device_info *info = &roots[i].info;
        if (info == passed_over || (info->kind == DUET_KIND_CPU) != cpu)
            continue;
        if (!best || strength(info) > strength(best))
            best = info;
    }
    return best;
}

static selector_pair name_both(const duet_device_info *a, const duet_device_info *b)
{
    selector_pair names;
    snprintf(names.a, sizeof names.a, "%s", a->selector);
    snprintf(names.b, sizeof names.b, "%s", b->selector);
    return names;
}

static selector_pair name_halves(const duet_device_info *cpu)
{
    if (!cpu->can_cut)
        return name_both(cpu, cpu);
    selector_pair names;
    uint32_t half = cpu->units / 2;
    snprintf(names.a, sizeof names.a, "%s[0-%u]", cpu->selector, half - 1);
    snprintf(names.b, sizeof names.b, "%s[%u-%u]", cpu->selector, half, cpu->units - 1);
    return names;
}

// Two CPU devices are two views of the same cores, so halves of one are the
// better pair; without a CPU the two strongest devices share the work.
static bool choose(selector_pair *names, duet_error *err)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    if (!device_list_roots(&roots, &n, err))
        return false;
    const duet_device_info *cpu = strongest(roots, n, true, NULL);
    const duet_device_info *first = strongest(roots, n, false, NULL);
    if (!first) {
        *names = name_halves(cpu);
    } else if (cpu) {
        *names = name_both(cpu, first);
    } else {
        const duet_device_info *second = strongest(roots, n, false, first);
        *names = name_both(first, second ? second : first);
    }
    return true;
}

static bool open_devices(duet_device_pair *pair, const duet_device_pair_def *def, duet_error *err)
{
    selector_pair chosen = {0};
    const char *a = def->a;
    const char *b = def->b;
    if (!a != !b)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a device pair needs two selectors, or none to have them chosen");
    if (!a) {
        if (!choose(&chosen, err))
            return false;
        a = chosen.a;
        b = chosen.b;
    }
    return device_open(&pair->devices[0], a, err) && device_open(&pair->devices[1], b, err);
}

static bool keep_folder(char **kept, const char *folder, duet_error *err)
{
    if (!folder || !*folder)
        return true;
    *kept = strdup(folder);
    return *kept || error_set(err, DUET_STATUS_NO_MEMORY, "a device pair: no memory");
}

duet_device_pair *duet_device_pair_create(const duet_device_pair_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "the def of a device pair begins with duet_default_device_pair_def");
        return NULL;
    }
    duet_device_pair *pair = calloc(1, sizeof *pair);
    if (!pair) {
        error_set(err, DUET_STATUS_NO_MEMORY, "a device pair: no memory");
        return NULL;
    }
    device_pair_hold(pair);
    bool ok = keep_folder(&pair->kernel_dir, def->kernel_dir, err);
    ok = ok && keep_folder(&pair->cache_dir, def->cache_dir, err);
    ok = ok && (!pair->cache_dir || cache_check(pair->cache_dir, err));
    ok = ok && open_devices(pair, def, err);
    if (!ok) {
        duet_device_pair_destroy(pair);
        return NULL;
    }
    return pair;
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
