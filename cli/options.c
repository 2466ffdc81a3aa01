// SPDX-License-Identifier: MIT
#include "cli/options.h"

#include "base/nearest.h"
#include "base/output.h"
#include "cli/interrupt.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "runtime/duet.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Says what is wrong with the command line; false.
#define REFUSE(line, ...) (say_wrong((line)->name, __VA_ARGS__), false)

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

static const option *find_name(const command_line *line, const char *name, size_t length)
{
    for (const option *o = line->options; o->name; ++o)
        if (strlen(o->name) == length && memcmp(o->name, name, length) == 0)
            return o;
    return NULL;
}

static bool read_number(const char *written, double *number)
{
    char *end = NULL;
    if (*written == '\0' || isspace((unsigned char)*written))
        return false;
    *number = strtod(written, &end);
    return *end == '\0' && isfinite(*number);
}

static double read_suffix(const char **at)
{
    static const char suffixes[] = "kMG";
    const char *found = **at ? strchr(suffixes, **at == 'K' ? 'k' : **at) : NULL;
    *at += found != NULL;
    return found ? pow(1e3, (double)(found - suffixes + 1)) : 1;
}

// Digits alone are read exactly; with a point, an exponent or a suffix as a double.
const char *options_read_count(const char *written, uint64_t *count)
{
    char *end = NULL;
    if (!isdigit((unsigned char)*written))
        return NULL;
    errno = 0;
    *count = strtoull(written, &end, 10);
    if (!*end || !strchr(".eEkKMG", *end))
        return errno == 0 ? end : NULL;
    double number = strtod(written, &end);
    const char *after = end;
    number *= read_suffix(&after);
    if (!(number < 0x1p64) || number != floor(number))
        return NULL;
    *count = (uint64_t)number;
    return after;
}

static bool read_count(const char *written, uint64_t *count)
{
    const char *after = options_read_count(written, count);
    return after && *after == '\0';
}

// "0.25", "1/4", "1" -> out of DUET_SHARE_ONE, to the nearest.
static bool options_read_share(const char *written, uint32_t *share)
{
    char first[64];
    double parts = 1;
    double whole = 1;
    const char *slash = strchr(written, '/');
    size_t length = slash ? (size_t)(slash - written) : strlen(written);
    if (length >= sizeof first)
        return false;
    memcpy(first, written, length);
    first[length] = '\0';
    if (!read_number(first, &parts) || (slash && !read_number(slash + 1, &whole)))
        return false;
    if (!(whole > 0) || !(parts >= 0) || !(parts <= whole))
        return false;
    *share = (uint32_t)lround(parts / whole * DUET_SHARE_ONE);
    return true;
}

static bool refuse_range(const command_line *line, const option *o, const char *written,
                         const char *what)
{
    if (o->most > 0)
        return REFUSE(line, "--%s '%s': give %s from %.10g to %.10g", o->name, written, what,
                      o->least, o->most);
    return REFUSE(line, "--%s '%s': give %s of at least %.10g", o->name, written, what, o->least);
}

static bool is_within(const option *o, double value)
{
    return value >= o->least && (o->most == 0 || value <= o->most);
}

static bool add_setting(const command_line *line, const option *o, const char *written,
                        option_list *list)
{
    const char *equals = strchr(written, '=');
    if (!equals || equals == written)
        return REFUSE(line, "--%s '%s': give a name and a value, as seed=7", o->name, written);
    if (list->n == OPTION_LIST_MOST)
        return REFUSE(line, "--%s is given more than %d times", o->name, OPTION_LIST_MOST);
    list->items[list->n++] = written;
    return true;
}

static bool set_value(const command_line *line, const option *o, const char *written, void *args)
{
    void *at = (char *)args + o->at;
    double number = 0;
    uint64_t count = 0;
    switch (o->kind) {
    case KIND_FLAG:
        *(bool *)at = true;
        return true;
    case KIND_TEXT:
    case KIND_INPUT:
    case KIND_OUTPUT:
    case KIND_LATER:
        *(const char **)at = written;
        return true;
    case KIND_SETTINGS:
        return add_setting(line, o, written, at);
    case KIND_COUNT:
        if (!read_count(written, &count) || !is_within(o, (double)count))
            return refuse_range(line, o, written, "a whole number");
        *(uint64_t *)at = count;
        return true;
    case KIND_NUMBER:
        if (!read_number(written, &number) || !is_within(o, number))
            return refuse_range(line, o, written, "a number");
        *(double *)at = number;
        return true;
    case KIND_SHARE:
        if (!options_read_share(written, at))
            return REFUSE(line, "--%s '%s': give a part from 0 to 1, as 0.25 or 1/4", o->name,
                          written);
        return true;
    }
    return false;
}

static void add_row(table *t, const char *name, const char *value, const char *help)
{
    char letter[8] = "";
    if (letter_of(name))
        snprintf(letter, sizeof letter, "-%c, ", letter_of(name));
    table_cell(t, "  %s--%s%s%s", letter, name, value ? " " : "", value ? value : "");
    table_cell(t, "%s", help);
}

static void print_help(const command_line *line)
{
    printf("duet %s%s%s [options]\n%s\n\n", line->name, *line->operands ? " " : "", line->operands,
           line->about);
    table t = table_begin("ll");
    for (const option *o = line->options; o->name; ++o)
        add_row(&t, o->name, o->value, o->help);
    add_row(&t, "help", NULL, "this text");
    table_print(&t, stdout);
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
    a->option = find_name(line, name, length);
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
    if (attached && (o->kind == KIND_FLAG || find_name(line, name, strcspn(name, "="))))
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
    return set_value(line, o, value, args);
}

// Which options were given, by their place in the table.
enum { OPTIONS_MOST = 64 };

typedef struct given_options {
    bool at[OPTIONS_MOST];
} given_options;

static bool is_given(const command_line *line, const given_options *given, const char *name,
                     size_t length)
{
    const option *o = find_name(line, name, length);
    return o && given->at[o - line->options];
}

bool options_is_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

// stdout holds one thing: one output, or the object of --json.
static bool check_stdout(const command_line *line, const given_options *given, const void *args)
{
    const option *first = NULL;
    for (const option *o = line->options; o->name; ++o) {
        const char *at = (const char *)args + o->at;
        bool prints = o->kind == KIND_OUTPUT ? options_is_stdout(*(const char *const *)at)
                                             : strcmp(o->name, "json") == 0;
        if (!prints || !given->at[o - line->options])
            continue;
        if (first)
            return REFUSE(line, "--%s and --%s would both write to stdout", first->name, o->name);
        first = o;
    }
    return true;
}

// The file that an option of the kind, or of `or_kind`, names; NULL: it is of another or not given.
static const char *file_of(const option *o, const void *args, option_kind kind, option_kind or_kind)
{
    const char *at = (const char *)args + o->at;
    return o->kind == kind || o->kind == or_kind ? *(const char *const *)at : NULL;
}

// One output against what is read and the outputs of rows before it.
static bool check_place(const command_line *line, const option *out, const char *path,
                        const void *args, char **operands)
{
    bool is_read = false;
    const option *also = NULL;
    for (char **operand = operands; *operand; ++operand)
        is_read = is_read || output_replaces(*operand, path);
    for (const option *o = line->options; o->name; ++o) {
        const char *input = file_of(o, args, KIND_INPUT, KIND_INPUT);
        const char *before = o < out ? file_of(o, args, KIND_OUTPUT, KIND_LATER) : NULL;
        is_read = is_read || (input && output_replaces(input, path));
        also = before && output_replaces(before, path) ? o : also;
    }
    if (is_read)
        return REFUSE(line, "--%s %s would overwrite what is read", out->name,
                      say_name(path).chars);
    return !also || REFUSE(line, "--%s and --%s would both write %s", also->name, out->name,
                           say_name(path).chars);
}

static bool check_places(const command_line *line, const void *args, char **operands)
{
    for (const option *o = line->options; o->name; ++o) {
        const char *path = file_of(o, args, KIND_OUTPUT, KIND_LATER);
        if (path && !check_place(line, o, path, args, operands))
            return false;
    }
    return true;
}

static bool check_rules(const command_line *line, const given_options *given)
{
    for (const option_rule *r = line->rules; r && r->options; ++r)
        for (const char *at = r->options; *at; at += strspn(at, " ")) {
            size_t length = strcspn(at, " ");
            if (is_given(line, given, at, length) &&
                is_given(line, given, r->other, strlen(r->other)) != (r->kind == OPTION_NEEDS))
                return REFUSE(line,
                              r->kind == OPTION_NEEDS ? "--%.*s does nothing without --%s"
                                                      : "--%.*s and --%s do not go together",
                              (int)length, at, r->other);
            at += length;
        }
    return true;
}

static bool check_operands(const command_line *line, int n, char **operands)
{
    if (n < line->least_operands)
        return REFUSE(line, "%s is missing; 'duet %s --help' says what it is", line->operands,
                      line->name);
    if (n > line->most_operands)
        return REFUSE(line, "unexpected argument '%s'; 'duet %s --help' shows the form",
                      operands[line->most_operands], line->name);
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
            print_help(line);
            p->exit_code = EXIT_OK;
            return false;
        }
        if (!take_option(line, &a, argc, argv, &i, args))
            return false;
        given.at[a.option - line->options] = true;
    }
    p->operands[p->n] = NULL;
    return check_operands(line, p->n, p->operands) && check_rules(line, &given) &&
           check_stdout(line, &given, args) && check_places(line, args, p->operands);
}

static bool check_outputs(const command_line *line, const void *args, duet_error *err)
{
    for (const option *o = line->options; o->name; ++o) {
        const char *path = file_of(o, args, KIND_OUTPUT, KIND_OUTPUT);
        if (path && !output_check(path, err))
            return false;
    }
    return true;
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
    if (!check_outputs(line, args, &err))
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
