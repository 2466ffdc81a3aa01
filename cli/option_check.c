// SPDX-License-Identifier: MIT
// Checks of options against each other, and of the files that they name.
#include "cli/option.h"

#include "base/output.h"

#include <string.h>

const option *option_find(const command_line *line, const char *name, size_t length)
{
    for (const option *o = line->options; o->name; ++o)
        if (strlen(o->name) == length && memcmp(o->name, name, length) == 0)
            return o;
    return NULL;
}

static bool is_given(const command_line *line, const given_options *given, const char *name,
                     size_t length)
{
    const option *o = option_find(line, name, length);
    return o && given->at[o - line->options];
}

bool option_is_given(const command_line *line, const given_options *given, const char *name)
{
    return is_given(line, given, name, strlen(name));
}

bool options_is_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

// stdout holds one thing: one output, or the object of --json.
bool option_check_stdout(const command_line *line, const given_options *given, const void *args)
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

bool option_check_places(const command_line *line, const void *args, char **operands)
{
    for (const option *o = line->options; o->name; ++o) {
        const char *path = file_of(o, args, KIND_OUTPUT, KIND_LATER);
        if (path && !check_place(line, o, path, args, operands))
            return false;
    }
    return true;
}

bool option_check_rules(const command_line *line, const given_options *given)
{
    for (const option_rule *r = line->rules; r && r->options; ++r)
        for (const char *at = r->options; *at; at += strspn(at, " ")) {
            size_t length = strcspn(at, " ");
            if (is_given(line, given, at, length) &&
                option_is_given(line, given, r->other) != (r->kind == OPTION_NEEDS))
                return REFUSE(line,
                              r->kind == OPTION_NEEDS ? "--%.*s does nothing without --%s"
                                                      : "--%.*s and --%s do not go together",
                              (int)length, at, r->other);
            at += length;
        }
    return true;
}

bool option_check_outputs(const command_line *line, const void *args, duet_error *err)
{
    for (const option *o = line->options; o->name; ++o) {
        const char *path = file_of(o, args, KIND_OUTPUT, KIND_OUTPUT);
        if (path && !output_check(path, err))
            return false;
    }
    return true;
}
