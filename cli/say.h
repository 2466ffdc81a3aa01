// SPDX-License-Identifier: MIT
// What the program says: one line for a failure, one object for --json, and how far
// long work is.
#ifndef CLI_SAY_H
#define CLI_SAY_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

struct cJSON;
struct text;

enum { EXIT_OK = 0, EXIT_FAILED = 1, EXIT_WRONG = 2, EXIT_INTERRUPTED = 130 };

// "duet: LINE" on stderr. Returns EXIT_FAILED, EXIT_INTERRUPTED for INTERRUPTED, or
// EXIT_WRONG for BAD_ARGUMENT: a value that the library finds wrong, or a name that it does not
// know, was typed. A file that does not exist is EXIT_FAILED.
int say_failed(const duet_error *err);

// That exit status alone.
int say_status(const duet_error *err);

// "duet COMMAND: LINE" on stderr. Returns EXIT_WRONG.
int say_wrong(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

// "duet: note: LINE" on stderr: something that a person should know, and no failure.
void say_note(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Prints the object on stdout and deletes it. false if memory ran out.
bool say_json(struct cJSON *object, duet_error *err);

// A name from a file, a store or a driver, on one line and without what a
// terminal would obey; a very long one is cut. Nothing for NULL.
typedef struct said {
    char chars[512];
} said;

said say_name(const char *name);

// "1 677 345"; "1 box", "2 000 boxes"
typedef struct counted {
    char chars[128];
} counted;

counted say_count(uint64_t n);
counted say_things(uint64_t n, const char *one, const char *many);

// In characters; 0: the file is no terminal.
int say_terminal_width(int file);

// Prints such a text, whose lines and tabs stay.
void say_lines(const char *lines);

// Writes a text to a file, and frees it.
bool say_to_file(struct text *chars, const char *path, duet_error *err);

// Writes out what stdout still holds. A full disk or a reader that went away
// is a failure: false, and a line on stderr.
bool say_finish(void);

// A line on the terminal that tells how far long work is: its rate and the
// time left. Nothing is shown where stderr is not a terminal. Nested works
// are shown by the outermost and the innermost: "case 3 of 24, 40 s left; kernel 2
// of 9".
typedef struct progress {
    const char *what; // "step", "launch"; up to 100 characters
    uint64_t total;   // 0: not known
    uint64_t begun_ns;
    uint64_t shown_ns;
    bool on_terminal;
    bool is_part;  // is a part of another
    bool follows;  // shows the progress of the library
    char note[48]; // behind the rest; "": nothing
} progress;

// Has progress shown where stderr is a pipe to a terminal.
void say_on_terminal(void);

progress progress_begin(const char *what, uint64_t total);
// Shows "what done of total, rate, time left", or "what" at first if the total is not known; at
// most ten times a second.
void progress_show(progress *p, uint64_t done);
void progress_hide(progress *p); // before something else is printed
void progress_end(progress *p);  // clears the line

// Draws the line in place of the one before, cut to the terminal's width.
void progress_line(const char *line);

// Shows in percent how far the library's own work is until progress_end; Ctrl-C ends that.
void progress_follow(progress *p);

#endif
