// SPDX-License-Identifier: MIT
#include "cli/command_text.h"

#include "base/visible.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                            "_-+=:,./@%";

static bool is_visible(const char *word)
{
    for (size_t length; *word; word += length) {
        length = utf8_length(word);
        if (length == 0 || utf8_is_control(word, length))
            return false;
    }
    return true;
}

static void add_escaped(text *t, const char *word)
{
    text_add(t, "\"$(printf '");
    for (; *word; ++word)
        text_add(t, isalnum((unsigned char)*word) ? "%c" : "\\%03o", (unsigned char)*word);
    text_add(t, "')\"");
}

static void add_quoted(text *t, const char *word)
{
    text_add(t, "'");
    for (; *word; ++word)
        text_add(t, *word == '\'' ? "'\\''" : "%c", *word);
    text_add(t, "'");
}

// Adds the word, quoted for a POSIX shell. A word with control characters or invalid UTF-8 is
// written as octal numbers for printf, so that a terminal shows it safely.
static void add_word(text *t, const char *word)
{
    text_add(t, " ");
    if (*word && word[strspn(word, plain)] == '\0')
        text_add(t, "%s", word);
    else
        (is_visible(word) ? add_quoted : add_escaped)(t, word);
}

void command_text_option(text *t, const char *name, const char *value)
{
    text_add(t, " --%s", name);
    add_word(t, value);
}

// A path like an option would be read as one.
void command_text_scene(text *t, const char *path, const scene_options *options)
{
    text file = {0};
    text_add(&file, "%s%s", path[0] == '-' && path[1] ? "./" : "", path);
    add_word(t, text_chars(&file));
    text_free(&file);
    command_text_settings(t, options);
}

void command_text_settings(text *t, const scene_options *options)
{
    if (options->n != UINT64_MAX)
        text_add(t, " -n %" PRIu64, options->n);
    if (options->seed != UINT64_MAX)
        text_add(t, " --seed %" PRIu64, options->seed);
    for (uint32_t i = 0; i < options->settings.n; ++i)
        command_text_option(t, "set", options->settings.items[i].written);
}

void command_text_pair(text *t, const duet_device_pair *pair)
{
    const char *a = duet_device_pair_get_info(pair, 0)->selector;
    const char *b = duet_device_pair_get_info(pair, 1)->selector;
    bool one = duet_device_pair_is_one(pair);
    text both = {0};
    text_add(&both, "%s%s%s", a, one ? "" : ",", one ? "" : b);
    command_text_option(t, "pair", text_chars(&both));
    text_free(&both);
}

void command_text_plan(text *t, double share, const char *mode, const char *variant_a,
                       const char *variant_b, bool one)
{
    text_add(t, " --share %.5g", share); // out of DUET_SHARE_ONE five digits are exact
    command_text_option(t, "mode", mode);
    if (one || strcmp(variant_a, variant_b) == 0) {
        command_text_option(t, "variant", variant_b);
        return;
    }
    command_text_option(t, "variant-a", variant_a);
    command_text_option(t, "variant-b", variant_b);
}

// Adds the shortest number that is read as this one, if it was given.
static void add_rate(text *t, const char *name, double rate)
{
    char number[32] = "0";
    if (rate < 0)
        return;
    for (int digits = 1; digits <= 17 && strtod(number, NULL) != rate; ++digits)
        snprintf(number, sizeof number, "%.*g", digits, rate);
    command_text_option(t, name, number);
}

void command_text_level(text *t, const level_options *options)
{
    if (options->level)
        command_text_option(t, "level", options->level);
    add_rate(t, "missed", options->missed);
    add_rate(t, "false-rate", options->false_rate);
}
