// SPDX-License-Identifier: MIT
#include "cli/options.h"

#include "cli/say.h"
#include "runtime/duet.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const option *find_name(const command_line *line, const char *name, size_t length)
{
    for (const option *o = line->options; o->name; ++o)
        if (strlen(o->name) == length && memcmp(o->name, name, length) == 0)
            return o;
    return NULL;
}

static bool read_number(const char *text, double *number)
{
    char *end = NULL;
    if (*text == '\0' || isspace((unsigned char)*text))
        return false;
    *number = strtod(text, &end);
    return *end == '\0' && isfinite(*number);
}

static bool read_count(const char *text, uint64_t *count)
{
    char *end = NULL;
    if (!isdigit((unsigned char)*text))
        return false;
    errno = 0;
    *count = strtoull(text, &end, 10);
    return *end == '\0' && errno == 0;
}

// "0.25", "1/4", "1" -> out of DUET_SHARE_ONE, to the nearest.
static bool options_read_share(const char *text, uint32_t *share)
{
    char first[64];
    double parts = 1;
    double whole = 1;
    const char *slash = strchr(text, '/');
    size_t length = slash ? (size_t)(slash - text) : strlen(text);
    if (length >= sizeof first)
        return false;
    memcpy(first, text, length);
    first[length] = '\0';
    if (!read_number(first, &parts) || (slash && !read_number(slash + 1, &whole)))
        return false;
    if (!(whole > 0) || !(parts >= 0) || !(parts <= whole))
        return false;
    *share = (uint32_t)lround(parts / whole * DUET_SHARE_ONE);
    return true;
}

static bool refuse_range(const command_line *line, const option *o, const char *text,
                         const char *what)
{
    if (o->most > 0)
        say_wrong(line->name, "--%s '%s': give %s from %.10g to %.10g", o->name, text, what,
                  o->least, o->most);
    else
        say_wrong(line->name, "--%s '%s': give %s of at least %.10g", o->name, text, what,
                  o->least);
    return false;
}

static bool is_within(const option *o, double value)
{
    return value >= o->least && (o->most == 0 || value <= o->most);
}

static bool add_setting(const command_line *line, const option *o, const char *text,
                        option_list *list)
{
    const char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        say_wrong(line->name, "--%s '%s': give a name and a value, as seed=7", o->name, text);
        return false;
    }
    if (list->n == OPTION_LIST_MOST) {
        say_wrong(line->name, "--%s is given more than %d times", o->name, OPTION_LIST_MOST);
        return false;
    }
    list->items[list->n++] = text;
    return true;
}

static bool set_value(const command_line *line, const option *o, const char *text, void *args)
{
    void *at = (char *)args + o->at;
    double number = 0;
    uint64_t count = 0;
    switch (o->kind) {
    case KIND_FLAG:
        *(bool *)at = true;
        return true;
    case KIND_TEXT:
        *(const char **)at = text;
        return true;
    case KIND_SETTINGS:
        return add_setting(line, o, text, at);
    case KIND_COUNT:
        if (!read_count(text, &count) || !is_within(o, (double)count))
            return refuse_range(line, o, text, "a whole number");
        *(uint64_t *)at = count;
        return true;
    case KIND_NUMBER:
        if (!read_number(text, &number) || !is_within(o, number))
            return refuse_range(line, o, text, "a number");
        *(double *)at = number;
        return true;
    case KIND_SHARE:
        if (!options_read_share(text, at)) {
            say_wrong(line->name, "--%s '%s': give a part from 0 to 1, as 0.25 or 1/4", o->name,
                      text);
            return false;
        }
        return true;
    }
    return false;
}

static void print_row(const char *name, const char *value, const char *help)
{
    char left[64];
    char letter[8] = "";
    if (strlen(name) == 1)
        snprintf(letter, sizeof letter, "-%s, ", name);
    snprintf(left, sizeof left, "%s--%s%s%s", letter, name, value ? " " : "", value ? value : "");
    printf("  %-18s %s\n", left, help);
}

static void print_help(const command_line *line)
{
    printf("duet %s%s%s [options]\n%s\n\n", line->name, *line->operands ? " " : "", line->operands,
           line->about);
    for (const option *o = line->options; o->name; ++o)
        print_row(o->name, o->value, o->help);
    print_row("help", NULL, "this text");
}

// What one argument asks for: an option with or without its value in it.
typedef struct asked {
    const option *option;
    const char *value; // after "=", or NULL
    bool help;
} asked;

static bool recognise(const command_line *line, const char *argument, asked *a)
{
    *a = (asked){0};
    const char *name = argument + (argument[1] == '-' ? 2 : 1);
    size_t length = strcspn(name, "=");
    if (argument[1] == '-' || length == 1) {
        a->option = find_name(line, name, length);
        a->value = name[length] == '=' ? name + length + 1 : NULL;
        a->help = !a->option && (strcmp(name, "help") == 0 || strcmp(name, "h") == 0);
    }
    if (a->option || a->help)
        return true;
    say_wrong(line->name, "there is no option '%s'; 'duet %s --help' lists those there are",
              argument, line->name);
    return false;
}

// Sets one option; *i moves on where its value is the next argument.
static bool take_option(const command_line *line, const asked *a, int argc, char **argv, int *i,
                        void *args)
{
    const option *o = a->option;
    const char *value = a->value;
    if (o->kind == KIND_FLAG && value) {
        say_wrong(line->name, "--%s takes no value", o->name);
        return false;
    }
    if (o->kind != KIND_FLAG && !value) {
        if (*i + 1 >= argc) {
            say_wrong(line->name, "--%s needs a value: --%s %s", o->name, o->name, o->value);
            return false;
        }
        value = argv[++*i];
    }
    return set_value(line, o, value, args);
}

static bool check_operands(const command_line *line, int n, char **operands)
{
    if (n < line->least_operands) {
        say_wrong(line->name, "%s is missing: duet %s %s", line->operands, line->name,
                  line->operands);
        return false;
    }
    if (n > line->most_operands) {
        say_wrong(line->name, "'%s' is one argument too many; 'duet %s --help' shows the form",
                  operands[line->most_operands], line->name);
        return false;
    }
    return true;
}

// What is parsed: the operands, and how the program ends where there is nothing to run.
typedef struct parsed {
    char **operands; // argv moved together; NULL after the last
    int n;
    int exit_code;
} parsed;

// False where help was asked for and printed, or the command line is wrong and a
// line on stderr says how.
static bool parse(const command_line *line, int argc, char **argv, void *args, parsed *p)
{
    bool only_operands = false;
    *p = (parsed){.operands = argv + 1, .exit_code = EXIT_WRONG};
    for (int i = 1; i < argc; ++i) {
        char *argument = argv[i];
        if (only_operands || argument[0] != '-' || argument[1] == '\0') {
            p->operands[p->n++] = argument;
            only_operands = only_operands || line->rest_is_operands;
            continue;
        }
        if (strcmp(argument, "--") == 0) {
            only_operands = true;
            continue;
        }
        asked a;
        if (!recognise(line, argument, &a))
            return false;
        if (a.help) {
            print_help(line);
            p->exit_code = EXIT_OK;
            return false;
        }
        if (!take_option(line, &a, argc, argv, &i, args))
            return false;
    }
    p->operands[p->n] = NULL;
    return check_operands(line, p->n, p->operands);
}

int options_run(const command_line *line, int argc, char **argv, void *args, command_body *run)
{
    parsed p;
    duet_error err = {0};
    if (!parse(line, argc, argv, args, &p))
        return p.exit_code;
    const char *wrong = line->refuse ? line->refuse(args, p.operands) : NULL;
    if (wrong)
        return say_wrong(line->name, "%s", wrong);
    return run(args, p.operands, &err) ? EXIT_OK : say_failed(&err);
}
