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
    return bad_argument(err, "variant '%s': expected auto, simd, gpu or paper", word);
}

// The words that a setting may be, by their numbers.
typedef struct setting_words {
    const char *name;
    const char *words[5]; // ends with NULL
    const char *expected;
} setting_words;

static const setting_words sorts = {"sort", {"counting", "radix"}, "sort=radix or sort=counting"};
static const setting_words paper_sorts = {"sort", {"", "radix"}, "sort=radix"};
static const setting_words grids = {
    "grid", {"auto", "uniform", "dense", "hashed"}, "auto, uniform, dense or hashed"};
static const setting_words sends = {"send", {"all", "chunks", "packed"}, "all, chunks or packed"};
static const setting_words cells = {"cells", {"free", "fixed"}, "free or fixed"};

// Reads the number of a word; -1: it is none of them.
static int read_word(const setting_words *of, const char *value, duet_error *err)
{
    for (int i = 0; of->words[i]; ++i)
        if (*value && strcmp(value, of->words[i]) == 0)
            return i;
    bad_argument(err, "variant: %s=%s is not possible; expected %s", of->name, value, of->expected);
    return -1;
}

static bool take_number(variant *v, char *word, const char *value, duet_error *err)
{
    char *end = NULL;
    long long number = strtoll(value, &end, 0);
    if (*end)
        return bad_argument(err, "variant: %s=%s: the value is not a whole number", word, value);
    if (v->n_settings == VARIANT_SETTINGS)
        return bad_argument(err, "variant: more than %d settings", VARIANT_SETTINGS);
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

static bool take_setting(variant *v, char *word, duet_error *err)
{
    char *equals = strchr(word, '=');
    if (!equals || equals == word || !equals[1])
        return bad_argument(err, "variant: '%s' is not NAME=VALUE", word);
    *equals = '\0';
    const char *value = equals + 1;
    int read = 0;
    if (strcmp(word, "sort") == 0)
        v->sort = read = read_word(v->search == SEARCH_PAPER ? &paper_sorts : &sorts, value, err);
    else if (strcmp(word, "grid") == 0)
        v->grid = read = read_word(&grids, value, err);
    else if (strcmp(word, "send") == 0)
        v->send = read = read_word(&sends, value, err);
    else if (strcmp(word, "cells") == 0)
        v->fixed = (read = read_word(&cells, value, err)) == 1;
    else
        return take_number(v, word, value, err);
    return read >= 0;
}

bool variant_parse(variant *v, const char *text, const duet_device_info *device, duet_error *err)
{
    *v = (variant){.send = SEND_ALL};
    char words[sizeof(((duet_plan *)0)->variant_a)];
    if (snprintf(words, sizeof words, "%s", text) >= (int)sizeof words)
        return bad_argument(err, "variant: longer than %zu characters", sizeof words - 1);
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

const char *duet_mode_name(duet_mode mode)
{
    switch (mode) {
    case DUET_MODE_SHARED:
        return "shared";
    case DUET_MODE_OWN:
        return "own";
    case DUET_MODE_SLAB:
        return "slab";
    case DUET_MODE_DEFAULT:
        return "default";
    }
    return NULL;
}

bool mode_from_name(const char *name, duet_mode *mode)
{
    const char *known;
    for (int m = 0; (known = duet_mode_name((duet_mode)m)); ++m) {
        if (strcmp(known, name) != 0)
            continue;
        *mode = (duet_mode)m;
        return true;
    }
    return false;
}

const char *mode_name(int mode)
{
    return duet_mode_name((duet_mode)mode);
}

const char *mode_to_search_name(int mode)
{
    return mode == DUET_MODE_DEFAULT ? NULL : mode_name(mode);
}
