// SPDX-License-Identifier: MIT
#include "cli/commands/source.h"

#include "base/error.h"
#include "base/rng.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/say.h"
#include "runtime/opencl/program.h"

#include <inttypes.h>
#include <stdio.h>

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

static bool check_kernel(gen *g, program_set *set, const char *name, const source_sample *sample,
                         checked *c, duet_error *err)
{
    gen_limits limits = program_set_limits(set);
    rng r = rng_seed(sample->seed);
    *c = (checked){0};
    if (!gen_count(g, name, &limits, &c->configs, err))
        return false;
    bool all = sample->most == 0 || c->configs <= sample->most;
    uint64_t n = all ? c->configs : sample->most;
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
    json_add(o, STRING("name", name), NUMBER("configs", c->configs),
             NUMBER("compiled", c->compiled), NUMBER("failed", c->failed));
    return o;
}

static bool check_each(gen *g, program_set *set, const char *only, const source_sample *sample,
                       cJSON *kernels, uint64_t *failed, duet_error *err)
{
    const char *name = only ? only : gen_kernel(g, 0);
    for (uint32_t i = 0; name; name = only ? NULL : gen_kernel(g, ++i)) {
        checked c;
        if (!check_kernel(g, set, name, sample, &c, err))
            return false;
        if (kernels)
            cJSON_AddItemToArray(kernels, checked_json(name, &c));
        else
            print_checked(name, &c);
        *failed += c.failed;
    }
    return true;
}

bool source_check(gen *g, const device *d, const char *only, const source_sample *sample, bool json,
                  duet_error *err)
{
    program_set *set = program_set_open(d, g, NULL, err);
    if (!set)
        return false;
    uint64_t failed = 0;
    cJSON *o = json ? cJSON_CreateObject() : NULL;
    json_add(o, STRING("device", d->info.selector));
    cJSON *kernels = cJSON_AddArrayToObject(o, "kernels");
    bool ok = check_each(g, set, only, sample, kernels, &failed, err);
    program_set_close(set);
    if (ok && o)
        ok = say_json(o, err);
    else
        cJSON_Delete(o);
    if (ok && failed > 0)
        ok =
            error_set(err, DUET_STATUS_BUILD_FAILED, "%" PRIu64 " config%s failed to compile on %s",
                      failed, failed == 1 ? "" : "s", d->info.selector);
    return ok;
}
