// SPDX-License-Identifier: MIT
// The command line of a subcommand, as a table: parsing, checking and --help
// are made from the same rows.
//
// "--name value", "--name=value" and, where a row has a letter, "-x value"; a
// lone "--" ends the options. --help belongs to every subcommand.
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum option_kind {
    OPTION_FLAG,   // bool
    OPTION_TEXT,   // const char *
    OPTION_LIST,   // option_list: may be given again and again
    OPTION_COUNT,  // uint64_t, a whole number from least to most
    OPTION_NUMBER, // double, from least to most
    OPTION_SHARE   // uint32_t out of DUET_SHARE_ONE, from "0.25" or "1/4"
} option_kind;

enum { OPTION_LIST_MOST = 64 };

typedef struct option_list {
    const char *items[OPTION_LIST_MOST];
    uint32_t n;
} option_list;

typedef struct option {
    const char *name;
    option_kind kind;
    size_t at;         // offset of its value in the arguments' struct
    const char *value; // what --help calls the value; NULL for a flag
    const char *help;  // one line; names the default
    double least, most;
    char letter; // or 0
} option;

// A subcommand's whole command line.
typedef struct command_line {
    const char *name;     // "run"
    const char *operands; // "SCENE|FILE", or ""
    int least_operands;
    int most_operands;
    const char *about;     // one line of help, a sentence
    const option *options; // ends with a row without name
    bool rest_is_operands; // what follows the first operand is passed on unread
} command_line;

// Reads argv[1...] into args, which holds the defaults, and *operands, which is
// argv moved together. false where the program is to end with *exit_code: help
// was asked for and printed (0), or the command line is wrong (2) and a line on
// stderr says how.
bool options_parse(const command_line *line, int argc, char **argv, void *args, char ***operands,
                   int *n_operands, int *exit_code);

// "0.25", "1/4", "1" -> out of DUET_SHARE_ONE, to the nearest.
bool options_read_share(const char *text, uint32_t *share);

#endif
