// SPDX-License-Identifier: MIT
// The command line of a subcommand, as a table: parsing, checking and --help
// are made from the same rows.
//
// "--name value" and "--name=value". Some names have a letter too, the same in every
// subcommand: -n --objects, -o --output, -e --eval, -i --interactive. A lone "--" ends
// the options. --help belongs to every subcommand.
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include "duet_error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum option_kind {
    KIND_FLAG,     // bool
    KIND_TEXT,     // const char *, not empty, as the following
    KIND_INPUT,    // const char *, a file to read, as the operands are
    KIND_OUTPUT,   // const char *, a file to write; "-" is stdout
    KIND_LATER,    // const char *, a file that the subcommand checks before it writes it
    KIND_SETTINGS, // option_list of "name=value"; may be given again and again
    KIND_COUNT,    // uint64_t, a whole number from least to most
    KIND_NUMBER,   // double, from least to most
    KIND_SHARE     // uint32_t out of DUET_SHARE_ONE, from "0.25" or "1/4"
} option_kind;

enum { OPTION_LIST_MOST = 64 };

typedef struct option_setting {
    const char *written; // "seed=7"
    char name[80];
    const char *value;
} option_setting;

typedef struct option_list {
    option_setting items[OPTION_LIST_MOST];
    uint32_t n;
} option_list;

// Adds a setting as it is written. False if it is none, or the list is full.
bool option_list_add(option_list *list, const char *written);

typedef struct command_option { // getopt.h has an option too
    const char *name;
    option_kind kind;
    size_t at;         // offset of its value in the arguments' struct
    const char *value; // the value's name in --help; NULL for a flag
    const char *help;  // one line; names the default
    double least;
    double most; // 0: no end
} option;

// Rows of a table whose values go into a struct named arguments, which each
// subcommand has; as is what --help calls the value.
#define OPTION_ROW(name_, kind_, member, as, about, from, to)                               \
    {                                                                                       \
        .name = (name_), .kind = (kind_), .at = offsetof(arguments, member), .value = (as), \
        .help = (about), .least = (from), .most = (to)                                      \
    }
#define OPTION_FLAG(name, member, about) OPTION_ROW(name, KIND_FLAG, member, NULL, about, 0, 0)
#define OPTION_TEXT(name, member, as, about) OPTION_ROW(name, KIND_TEXT, member, as, about, 0, 0)
#define OPTION_OUTPUT(name, member, as, about) \
    OPTION_ROW(name, KIND_OUTPUT, member, as, about, 0, 0)
#define OPTION_INPUT(name, member, as, about) OPTION_ROW(name, KIND_INPUT, member, as, about, 0, 0)
#define OPTION_LATER(name, member, as, about) OPTION_ROW(name, KIND_LATER, member, as, about, 0, 0)
#define OPTION_SETTINGS(name, member, as, about) \
    OPTION_ROW(name, KIND_SETTINGS, member, as, about, 0, 0)
#define OPTION_SHARE(name, member, as, about) OPTION_ROW(name, KIND_SHARE, member, as, about, 0, 0)
#define OPTION_COUNT(name, member, as, about, from, to) \
    OPTION_ROW(name, KIND_COUNT, member, as, about, from, to)
#define OPTION_NUMBER(name, member, as, about, from, to) \
    OPTION_ROW(name, KIND_NUMBER, member, as, about, from, to)

// Options that do nothing without another one, or together with it; "mode share" are two.
typedef struct option_rule {
    const char *options;
    enum { OPTION_NEEDS, OPTION_EXCLUDES } kind;
    const char *other;
} option_rule;

// A subcommand's whole command line.
typedef struct command_line {
    const char *name;         // "run"
    const char *operands;     // "SCENE|FILE"; [in brackets] may be left out, ... more. NULL: none
    int most_operands;        // 0: as many as operands names
    const char *instead;      // an option that names a file in the operand's place; NULL: none
    const char *about;        // one line of help, a sentence
    const option *options;    // ends with a row without name
    const option_rule *rules; // ends with {0}; NULL: none
    bool takes_empty;         // an operand may be '', with which each uid of a profile begins
    bool rest_is_operands;    // passes on what follows the first operand unread
    // Says what is wrong between options that are each right. NULL: nothing is wrong.
    const char *(*refuse)(const void *args, char **operands);
} command_line;

// Runs a subcommand with its arguments. operands end with NULL.
typedef bool command_body(void *args, char **operands, duet_error *err);

// Reads argv[1...] into args, which holds the defaults, and runs the subcommand.
// Returns the exit status; a line on stderr says what is wrong or failed.
int options_run(const command_line *line, int argc, char **argv, void *args, command_body *run);

// Defines a subcommand of one line, whose defaults these are.
#define SUBCOMMAND(name, ...)                              \
    int command_##name(int argc, char **argv)              \
    {                                                      \
        arguments args = {__VA_ARGS__};                    \
        return options_run(&line, argc, argv, &args, run); \
    }

// Whether an output goes to stdout, which then holds nothing else. NULL: none is asked for.
bool options_is_stdout(const char *path);

// "1000", "1e6", "250k", "1.5M", "2G": a whole number of at most 2^64 - 1. Returns what
// follows it, NULL if there is none.
const char *options_read_count(const char *text, uint64_t *count);

#endif
