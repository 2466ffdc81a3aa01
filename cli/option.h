// SPDX-License-Identifier: MIT
// Shared by the files behind options.h: values, and checks of options against each other. Each says
// on stderr what is wrong with the command line.
#ifndef CLI_OPTION_H
#define CLI_OPTION_H

#include "cli/options.h"
#include "cli/say.h"

// Says what is wrong with the command line; false.
#define REFUSE(line, ...) (say_wrong((line)->name, __VA_ARGS__), false)

const option *option_find(const command_line *line, const char *name, size_t length);

// Reads a value as the option's kind takes it, into its place in args.
bool option_set(const command_line *line, const option *o, const char *written, void *args);

// Which options were given, by their place in the table.
enum { OPTIONS_MOST = 64 };

typedef struct given_options {
    bool at[OPTIONS_MOST];
} given_options;

bool option_is_given(const command_line *line, const given_options *given, const char *name);

// Rules of the command line; one thing on stdout; no output in the place of what is read, or of
// another output.
bool option_check_rules(const command_line *line, const given_options *given);
bool option_check_stdout(const command_line *line, const given_options *given, const void *args);
bool option_check_places(const command_line *line, const void *args, char **operands);

// Whether outputs can be written, before the work that they are for.
bool option_check_outputs(const command_line *line, const void *args, duet_error *err);

#endif
