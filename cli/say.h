// SPDX-License-Identifier: MIT
// What the program says: one line for a failure, one object for --json.
#ifndef CLI_SAY_H
#define CLI_SAY_H

#include "duet_error.h"

#include <stdbool.h>

struct cJSON;

enum { EXIT_OK = 0, EXIT_FAILED = 1, EXIT_WRONG = 2 };

// "duet: LINE" on stderr. Returns EXIT_FAILED, or EXIT_WRONG for BAD_ARGUMENT:
// what the library finds wrong with a value came from the command line.
int say_failed(const duet_error *err);

// "duet COMMAND: LINE" on stderr. Returns EXIT_WRONG.
int say_wrong(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Prints the object on stdout and deletes it. false where memory ran out.
bool say_json(struct cJSON *object, duet_error *err);

// A name from a file, a store or a driver, on one line and without what a
// terminal would obey; a very long one is cut. Nothing for NULL.
typedef struct said {
    char chars[512];
} said;

said say_name(const char *name);

// Prints such a text, whose lines and tabs stay.
void say_lines(const char *lines);

// Writes out what stdout still holds. A full disk or a reader that went away
// is a failure: false, and a line on stderr.
bool say_finish(void);

#endif
