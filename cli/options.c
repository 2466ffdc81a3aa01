// SPDX-License-Identifier: MIT
#include "cli/option.h"

#include "base/nearest.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

// The letter that the name has too, in every subcommand; 0: it has none.
static char letter_of(const char *name)
{
    static const struct {
        char letter;
        const char *name;
    } letters[] = {{'e', "eval"}, {'i', "interactive"}, {'n', "objects"}, {'o', "output"}};
    for (size_t i = 0; i < sizeof letters / sizeof *letters; ++i)
        if (strcmp(letters[i].name, name) == 0)
            return letters[i].letter;
    return '\0';
}

static void add_row(cJSON *rows, const char *name, const char *value, const char *help)
{
    char letter[8] = "", flags[128];
    if (letter_of(name))
        snprintf(letter, sizeof letter, "-%c, ", letter_of(name));
    snprintf(flags, sizeof flags, "  %s--%s%s%s", letter, name, value ? " " : "",
             value ? value : "");
    json_add(json_add_row(rows), STRING("flags", flags), STRING("help", help));
}

static const char what_is_read[] =
    "\nSCENE is a name of 'duet scenes', or a .lua file that makes boxes.\n"
    "FILE has a box a row, as .npy or text: 6 numbers are its least and its greatest\n"
    "corner, 10 its centre, half extents and quaternion xyzw; in 2D 4, or 5 with an\n"
    "angle. A dash, -, is stdin.\n";

static int print_help(const command_line *line)
{
    duet_error err = {0};
    cJSON *rows = cJSON_CreateArray();
    const char *operands = line->operands ? line->operands : "";
    printf("duet %s%s%s [options]\n%s\n", line->name, *operands ? " " : "", operands, line->about);
    printf("%s\n", strstr(operands, "SCENE|FILE") ? what_is_read : "");
    for (const option *o = line->options; o->name; ++o)
        add_row(rows, o->name, o->value, o->help);
    add_row(rows, "help", NULL, "this text");
    bool ok = rendering_tell(rows, false, "cli/report/help.lua", &err);
    return ok ? EXIT_OK : say_failed(&err);
}

// One argument: an option with or without its value in it.
typedef struct asked {
    const option *option;
    const char *value; // after "=", or NULL
    bool help;
} asked;

static bool refuse_unknown(const command_line *line, const char *argument)
{
    char typed[64];
    const char *dashes = "--";
    const char *name = argument + strspn(argument, "-");
    snprintf(typed, sizeof typed, "%.*s", (int)strcspn(name, "="), name);
    nearest n = nearest_begin(typed);
    for (const option *o = line->options; o->name; ++o) {
        nearest_try(&n, o->name);
        if (*typed && letter_of(o->name) == typed[0] && typed[1] == '\0') {
            n.name = typed;
            dashes = "-";
        }
    }
    if (n.name)
        return REFUSE(line, "there is no option '%s'; did you mean '%s%s'?", argument, dashes,
                      n.name);
    return REFUSE(line, "there is no option '%s'; 'duet %s --help' lists those there are", argument,
                  line->name);
}

// "--objects", "--objects=9"
static void recognise_word(const command_line *line, const char *name, asked *a)
{
    size_t length = strcspn(name, "=");
    a->option = option_find(line, name, length);
    a->value = name[length] == '=' ? name + length + 1 : NULL;
}

// "-n", "-n9", "-n=9"; not "-objects", which lacks a dash.
static void recognise_letter(const command_line *line, const char *name, asked *a)
{
    const option *o = line->options;
    while (o->name && letter_of(o->name) != *name)
        ++o;
    o = o->name ? o : NULL;
    bool attached = o && name[1] != '\0' && name[1] != '=';
    if (attached && (o->kind == KIND_FLAG || option_find(line, name, strcspn(name, "="))))
        return;
    a->option = o;
    a->value = attached ? name + 1 : o && name[1] ? name + 2 : NULL;
}

static bool recognise(const command_line *line, const char *argument, asked *a)
{
    *a = (asked){0};
    if (argument[1] == '-')
        recognise_word(line, argument + 2, a);
    else
        recognise_letter(line, argument + 1, a);
    a->help = !a->option && (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0);
    return a->option || a->help || refuse_unknown(line, argument);
}

// Sets one option; *i moves on where its value is the next argument.
static bool take_option(const command_line *line, const asked *a, int argc, char **argv, int *i,
                        void *args)
{
    const option *o = a->option;
    const char *value = a->value;
    if (o->kind == KIND_FLAG && value)
        return REFUSE(line, "--%s takes no value", o->name);
    if (o->kind != KIND_FLAG && !value) {
        if (*i + 1 >= argc)
            return REFUSE(line, "--%s needs a value: --%s %s", o->name, o->name, o->value);
        value = argv[++*i];
    }
    return option_set(line, o, value, args);
}

// How many operands there are at least and at most. One that a file can stand for is needed, too.
static void count_operands(const command_line *line, int *least, int *most)
{
    const char *at = line->operands ? line->operands : "";
    *least = line->instead != NULL;
    *most = strstr(at, "...") ? INT_MAX : 0;
    for (; *at; at += strcspn(at, " "), at += *at == ' ') {
        *least += *at != '[';
        *most += *most < INT_MAX;
    }
    *most = line->most_operands ? line->most_operands : *most;
}

static bool check_operands(const command_line *line, const given_options *given, int n,
                           char **operands)
{
    const bool instead = line->instead && option_is_given(line, given, line->instead);
    const char *name = line->operands ? line->operands + strspn(line->operands, "[") : "";
    const int length = (int)strcspn(name, "]"), first = (int)strcspn(name, " ].");
    int least, most;
    count_operands(line, &least, &most);
    if (instead && n > 0)
        return REFUSE(line, "--%s: the file says what it is; give no %.*s", line->instead, length,
                      name);
    if (!instead && n < least)
        return REFUSE(line, "%.*s is missing; 'duet %s --help' says what it is", length, name,
                      line->name);
    if (n > most)
        return REFUSE(line, "unexpected argument '%s'; 'duet %s --help' shows the form",
                      operands[most], line->name);
    const int n_own = line->takes_empty ? 0 : line->rest_is_operands ? n > 0 : n;
    for (int i = 0; i < n_own; ++i)
        if (!*operands[i])
            return REFUSE(line, "%.*s is ''; 'duet %s --help' says what it is", first, name,
                          line->name);
    return true;
}

// The operands, and how the program ends if there is nothing to run.
typedef struct parsed {
    char **operands; // argv moved together; NULL after the last
    int n;
    int exit_code;
} parsed;

// False if help was asked for and printed, or the command line is wrong and a
// line on stderr says how.
static bool parse(const command_line *line, int argc, char **argv, void *args, parsed *p)
{
    bool only_operands = false;
    given_options given = {{false}};
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
            p->exit_code = print_help(line);
            return false;
        }
        if (!take_option(line, &a, argc, argv, &i, args))
            return false;
        given.at[a.option - line->options] = true;
    }
    p->operands[p->n] = NULL;
    return check_operands(line, &given, p->n, p->operands) && option_check_rules(line, &given) &&
           option_check_stdout(line, &given, args) && option_check_places(line, args, p->operands);
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
    if (!option_check_outputs(line, args, &err))
        return say_failed(&err);
    // Work until Ctrl-C may be worth telling, but is not all that was asked for.
    if (run(args, p.operands, &err) && interrupt_check(&err))
        return EXIT_OK;
    int status = say_failed(&err);
    if (!interrupt_asked())
        return status;
    interrupt_told();
    return EXIT_INTERRUPTED;
}
