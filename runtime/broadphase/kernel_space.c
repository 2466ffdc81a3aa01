// SPDX-License-Identifier: MIT
#include "runtime/broadphase/kernel_space.h"

#include "base/error.h"
#include "base/list.h"
#include "runtime/broadphase/world.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    const char *stages[KERNEL_SPACE_STAGES];
} kernels[] = {
    {"pair_search_simd", {"search", "candidates", "narrow"}},
    {"pair_search_gpu", {"search", "candidates", "narrow"}},
    {"pair_search_paper", {"candidates"}},
    {"narrow_simd", {"narrow"}},
    {"narrow", {"narrow"}},
    {"reorder_simd", {"reorder"}},
    {"reorder", {"reorder"}},
    {"bounds", {"bounds"}},
    {"hash", {"hash"}},
    {"scatter", {"sort"}},
    {"radix", {"sort"}},
    {"scan", {"sort"}},
    {"cell_start", {"cell start"}},
    {"clear", {"clear"}},
};

enum { N_KERNELS = sizeof kernels / sizeof kernels[0] };

// ---------------------------------------------------------------- what is free

static bool is_decided(const kernel_space_source *from, const char *name, const char *param)
{
    bool is = false;
    for (uint32_t i = 0; i < from->n_offers && !is; ++i) {
        const char *whose = from->offers[i].kernel;
        is = strcmp(from->offers[i].name, param) == 0 &&
             (!whose || !*whose || strcmp(whose, name) == 0);
    }
    return is;
}

static bool is_free(const kernel_space_source *from, const char *name, const gen_param *param)
{
    return param->n_values > 1 && param->n_values <= KERNEL_SPACE_VALUES &&
           !is_decided(from, name, param->name);
}

// ---------------------------------------------------------------- configs

// Lists what is offered to the kernel, and then the space's parameters.
typedef struct settings {
    gen_offer at[KERNEL_SPACE_OFFERS + KERNEL_SPACE_PARAMS];
    gen_offer *free;
} settings;

static void add_param(kernel_space *space, settings *s, const gen_param *param)
{
    s->free[space->n_params] = (gen_offer){NULL, param->name, 0, GEN_REQUIRED, NULL};
    snprintf(space->params[space->n_params].name, sizeof space->params[0].name, "%s", param->name);
    memcpy(space->params[space->n_params].values, param->values,
           param->n_values * sizeof *param->values);
    space->params[space->n_params++].n_values = param->n_values;
}

static bool list_params(const kernel_space_source *from, kernel_space *space, settings *s,
                        duet_error *err)
{
    const gen_param *params;
    uint32_t n_params;
    if (!gen_params(from->gen, space->kernel, &from->limits, &params, &n_params, err))
        return false;
    if (from->n_offers > 0)
        memcpy(s->at, from->offers, from->n_offers * sizeof *s->at);
    s->free = s->at + from->n_offers;
    for (uint32_t i = 0; i < n_params && space->n_params < KERNEL_SPACE_PARAMS; ++i)
        if (is_free(from, space->kernel, &params[i]))
            add_param(space, s, &params[i]);
    return true;
}

// Lists the configs that the card and the device allow; a card that is broken is an error.
static bool check_config(const kernel_space_source *from, const kernel_space *space,
                         const settings *s, bool *valid, duet_error *err)
{
    gen_variant made;
    duet_error why = {0};
    *valid = gen_make_offered(from->gen, space->kernel, s->at, from->n_offers + space->n_params,
                              &from->limits, &made, &why);
    gen_variant_free(&made);
    return *valid || why.status == DUET_STATUS_BAD_ARGUMENT || error_copy(err, &why);
}

// The next one in mixed radix order, the last parameter fastest; false after the last.
static bool step_config(const kernel_space *space, uint8_t config[KERNEL_SPACE_PARAMS])
{
    for (uint32_t i = space->n_params; i-- > 0;) {
        if (++config[i] < space->params[i].n_values)
            return true;
        config[i] = 0;
    }
    return false;
}

static bool list_configs(const kernel_space_source *from, const kernel *k, kernel_space *space,
                         settings *s, duet_error *err)
{
    uint8_t config[KERNEL_SPACE_PARAMS] = {0};
    do {
        bool valid, now = true;
        for (uint32_t i = 0; i < space->n_params; ++i) {
            gen_offer *setting = &s->free[i];
            setting->value = space->params[i].values[config[i]];
            now = now && setting->value == kernel_param(k, setting->name);
        }
        if (!check_config(from, space, s, &valid, err))
            return false;
        if (!valid)
            continue;
        if (now)
            space->now = space->n_configs;
        memcpy(space->configs[space->n_configs++], config, sizeof config);
    } while (space->n_configs < KERNEL_SPACE_CONFIGS && step_config(space, config));
    return true;
}

// ---------------------------------------------------------------- a kernel's space

void kernel_spaces_free(kernel_spaces *s)
{
    free(s->of);
    *s = (kernel_spaces){0};
}

bool kernel_spaces_add(kernel_spaces *s, const kernel_space *space, duet_error *err)
{
    kernel_space *of = list_room(s->of, s->n, sizeof *of, err);
    if (!of)
        return false;
    s->of = of;
    s->of[s->n++] = *space;
    return true;
}

bool kernel_space_read(const kernel_space_source *from, const char *name,
                       const char *const stages[KERNEL_SPACE_STAGES], const kernel *k,
                       kernel_spaces *to, duet_error *err)
{
    settings s;
    kernel_space space = {.n_configs = 0};
    assert(from->n_offers <= KERNEL_SPACE_OFFERS);
    snprintf(space.kernel, sizeof space.kernel, "%s", name);
    memcpy(space.stages, stages, sizeof space.stages);
    return list_params(from, &space, &s, err) && list_configs(from, k, &space, &s, err) &&
           (space.n_configs < 2 || kernel_spaces_add(to, &space, err));
}

static bool make_ready(duet_world *world, int side, duet_error *err)
{
    duet_result result;
    return world_is_prepared(world, side) || duet_world_step(world, &result, err);
}

bool kernel_spaces_read(duet_world *world, int side, kernel_spaces *to, duet_error *err)
{
    bool ok = make_ready(world, side, err);
    for (uint32_t i = 0; ok && world_is_prepared(world, side) && i < N_KERNELS; ++i) {
        const part *p = &world->parts[side];
        const kernel *k = part_kernel(p, kernels[i].name);
        const kernel_space_source from = {p->gen, p->limits, p->offers, p->n_offers};
        ok = !k || kernel_space_read(&from, kernels[i].name, kernels[i].stages, k, to, err);
    }
    return ok;
}

bool kernel_space_write(const kernel_space *space, uint32_t config, char text[DUET_VARIANT])
{
    size_t n = strlen(text);
    for (uint32_t i = 0; i < space->n_params && n < DUET_VARIANT; ++i) {
        uint8_t value = space->configs[config][i];
        if (value != space->configs[space->now][i])
            n += (size_t)snprintf(text + n, DUET_VARIANT - n, " %s.%s=%" PRId64, space->kernel,
                                  space->params[i].name, space->params[i].values[value]);
    }
    return n < DUET_VARIANT;
}
