// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/broadphase/variant.h"

#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// On a CPU rows lists its candidates first, so that finding and testing them
// have times of their own; simd does both at once.
static bool take_search(variant *v, const char *word, bool cpu, duet_error *err)
{
    const struct {
        const char *name;
        variant_search search;
        variant_sort sort;
        bool fused;
    } searches[] = {
        {"auto", cpu ? SEARCH_SIMD : SEARCH_GPU, SORT_COUNTING, !cpu},
        {"simd", SEARCH_SIMD, SORT_COUNTING, true},
        {"gpu", SEARCH_GPU, SORT_COUNTING, !cpu},
        {"paper", SEARCH_PAPER, SORT_RADIX, false},
    };
    for (size_t i = 0; i < sizeof searches / sizeof searches[0]; ++i) {
        if (strcmp(word, searches[i].name) != 0)
            continue;
        v->search = searches[i].search;
        v->sort = searches[i].sort;
        v->fused = searches[i].fused;
        return true;
    }
    return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "variant '%s': expected auto, simd, gpu or paper", word);
}

static bool take_sort(variant *v, const char *value, duet_error *err)
{
    if (strcmp(value, "counting") == 0 && v->search != SEARCH_PAPER)
        v->sort = SORT_COUNTING;
    else if (strcmp(value, "radix") == 0)
        v->sort = SORT_RADIX;
    else
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "variant: sort=%s is not possible; expected sort=radix%s", value,
                         v->search == SEARCH_PAPER ? "" : " or sort=counting");
    return true;
}

static bool take_grid(variant *v, const char *value, duet_error *err)
{
    static const char *const names[] = {"auto", "uniform", "dense", "hashed"};
    for (int i = 0; i < 4; ++i) {
        if (strcmp(value, names[i]) == 0) {
            v->grid = (variant_grid)i;
            return true;
        }
    }
    return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "variant: grid=%s is not possible; expected auto, uniform, dense or "
                     "hashed",
                     value);
}

static bool take_send(variant *v, const char *value, duet_error *err)
{
    static const char *const names[] = {
        [SEND_ALL] = "all", [SEND_CHUNKS] = "chunks", [SEND_PACKED] = "packed"};
    for (int i = 0; i < 3; ++i) {
        if (strcmp(value, names[i]) == 0) {
            v->send = (variant_send)i;
            return true;
        }
    }
    return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "variant: send=%s is not possible; expected all, chunks or packed", value);
}

static bool take_cells(variant *v, const char *value, duet_error *err)
{
    v->fixed = strcmp(value, "fixed") == 0;
    return v->fixed || strcmp(value, "free") == 0 ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "variant: cells=%s is not possible; expected free or fixed", value);
}

static bool take_setting(variant *v, char *word, duet_error *err)
{
    char *equals = strchr(word, '=');
    if (!equals || equals == word || !equals[1])
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "variant: '%s' is not NAME=VALUE", word);
    *equals = '\0';
    const char *value = equals + 1;
    if (strcmp(word, "sort") == 0)
        return take_sort(v, value, err);
    if (strcmp(word, "grid") == 0)
        return take_grid(v, value, err);
    if (strcmp(word, "send") == 0)
        return take_send(v, value, err);
    if (strcmp(word, "cells") == 0)
        return take_cells(v, value, err);
    char *end = NULL;
    long long number = strtoll(value, &end, 0);
    if (*end)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "variant: %s=%s: the value is not a whole number", word, value);
    if (v->n_settings == VARIANT_SETTINGS)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "variant: more than %d settings",
                         VARIANT_SETTINGS);
    char *dot = strchr(word, '.');
    if (dot)
        *dot = '\0';
    snprintf(v->settings[v->n_settings].kernel, sizeof v->settings[0].kernel, "%s",
             dot ? word : "");
    snprintf(v->settings[v->n_settings].name, sizeof v->settings[0].name, "%s",
             dot ? dot + 1 : word);
    v->settings[v->n_settings].value = number;
    ++v->n_settings;
    return true;
}

bool variant_parse(variant *v, const char *text, const duet_device_info *device, duet_error *err)
{
    *v = (variant){.send = SEND_ALL};
    char words[sizeof(((duet_plan *)0)->variant_a)];
    if (snprintf(words, sizeof words, "%s", text) >= (int)sizeof words)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "variant: longer than %zu characters",
                         sizeof words - 1);
    char *rest = NULL;
    char *word = strtok_r(words, " ,", &rest);
    bool ok = take_search(v, word ? word : "", device->kind == DUET_KIND_CPU, err);
    while (ok && (word = strtok_r(NULL, " ,", &rest)))
        ok = take_setting(v, word, err);
    return ok;
}

bool variant_is(const variant *a, const variant *b)
{
    bool same = a->search == b->search && a->sort == b->sort && a->grid == b->grid &&
                a->send == b->send && a->fixed == b->fixed && a->fused == b->fused &&
                a->n_settings == b->n_settings;
    for (uint32_t i = 0; same && i < a->n_settings; ++i) {
        const variant_setting *of_a = &a->settings[i], *of_b = &b->settings[i];
        same = of_a->value == of_b->value && strcmp(of_a->kernel, of_b->kernel) == 0 &&
               strcmp(of_a->name, of_b->name) == 0;
    }
    return same;
}

bool variant_sets(const variant *v, const char *kernel, const char *param)
{
    for (uint32_t i = 0; i < v->n_settings; ++i) {
        const char *whose = v->settings[i].kernel;
        if (strcmp(v->settings[i].name, param) == 0 && (!*whose || strcmp(whose, kernel) == 0))
            return true;
    }
    return false;
}
