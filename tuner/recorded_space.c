// SPDX-License-Identifier: MIT
#include "tuner/recorded_space.h"

#include <stdio.h>
#include <string.h>

// One word of a variant: "k.WG=64".
typedef struct setting {
    char kernel[48];
    char param[24];
    long long value;
} setting;

static bool read_setting(const char *word, setting *s)
{
    return sscanf(word, "%47[^. =].%23[^. =]=%lld", s->kernel, s->param, &s->value) == 3;
}

// The place of a kernel, which is added if it is new; n if there is no space.
static uint32_t find_kernel(recorded_space *s, const char *name)
{
    uint32_t at = 0;
    while (at < s->n && strcmp(s->kernels[at].kernel, name) != 0)
        ++at;
    if (at == s->n && at < SEARCH_KERNELS) {
        kernel_space *k = &s->kernels[s->n++];
        *k = (kernel_space){.n_configs = 1}; // the config that ran at first
        snprintf(k->kernel, sizeof k->kernel, "%s", name);
    }
    return at;
}

static uint32_t find_param(kernel_space *k, const char *name)
{
    uint32_t at = 0;
    while (at < k->n_params && strcmp(k->params[at].name, name) != 0)
        ++at;
    if (at == k->n_params && at < KERNEL_SPACE_PARAMS) {
        snprintf(k->params[at].name, sizeof k->params[at].name, "%s", name);
        k->params[at].values[0] = RECORDED_DEFAULT;
        k->params[at].n_values = 1;
        ++k->n_params;
    }
    return at;
}

static uint32_t find_value(kernel_space *k, uint32_t param, int64_t value)
{
    uint32_t at = 0, n = k->params[param].n_values;
    while (at < n && k->params[param].values[at] != value)
        ++at;
    if (at == n && at < KERNEL_SPACE_VALUES) {
        k->params[param].values[at] = value;
        ++k->params[param].n_values;
    }
    return at;
}

static void add_config(kernel_space *k, const uint8_t config[KERNEL_SPACE_PARAMS])
{
    for (uint32_t i = 0; i < k->n_configs; ++i)
        if (memcmp(k->configs[i], config, KERNEL_SPACE_PARAMS) == 0)
            return;
    if (k->n_configs < KERNEL_SPACE_CONFIGS)
        memcpy(k->configs[k->n_configs++], config, KERNEL_SPACE_PARAMS);
}

// False if the setting is beyond a limit.
static bool apply(recorded_space *s, const setting *word,
                  uint8_t configs[SEARCH_KERNELS][KERNEL_SPACE_PARAMS])
{
    uint32_t kernel = find_kernel(s, word->kernel);
    if (kernel == SEARCH_KERNELS)
        return false;
    uint32_t param = find_param(&s->kernels[kernel], word->param);
    if (param == KERNEL_SPACE_PARAMS)
        return false;
    uint32_t value = find_value(&s->kernels[kernel], param, word->value);
    configs[kernel][param] = (uint8_t)value;
    return value < KERNEL_SPACE_VALUES;
}

// The configs that a variant sets; false if one is beyond a limit.
static bool read_configs(recorded_space *s, const char *variant,
                         uint8_t configs[SEARCH_KERNELS][KERNEL_SPACE_PARAMS])
{
    size_t base = 0;
    bool fits = true;
    for (const char *word = variant; *word;) {
        setting found;
        size_t length = strcspn(word, " ");
        if (read_setting(word, &found))
            fits = fits && apply(s, &found, configs);
        else
            base = (size_t)(word - variant) + length;
        word += length + strspn(word + length, " ");
    }
    snprintf(s->base, sizeof s->base, "%.*s", (int)base, variant);
    return fits;
}

void recorded_space_add(recorded_space *s, const char *variant)
{
    uint8_t configs[SEARCH_KERNELS][KERNEL_SPACE_PARAMS] = {{0}};
    bool fits = read_configs(s, variant, configs);
    for (uint32_t i = 0; fits && i < s->n; ++i)
        add_config(&s->kernels[i], configs[i]);
}

void recorded_space_order(recorded_space *s, char variant[DUET_VARIANT])
{
    uint8_t configs[SEARCH_KERNELS][KERNEL_SPACE_PARAMS] = {{0}};
    if (!read_configs(s, variant, configs))
        return;
    snprintf(variant, DUET_VARIANT, "%s", s->base);
    for (uint32_t i = 0; i < s->n; ++i) {
        const kernel_space *k = &s->kernels[i];
        uint32_t config = 0;
        while (config < k->n_configs &&
               memcmp(k->configs[config], configs[i], sizeof *configs) != 0)
            ++config;
        if (config < k->n_configs)
            kernel_space_write(k, config, variant);
    }
}
