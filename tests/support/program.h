// SPDX-License-Identifier: MIT
// Runs the program `duet` as a person would, and holds what it printed.
#ifndef TESTS_PROGRAM_H
#define TESTS_PROGRAM_H

#include <stdarg.h>
#include <sys/types.h>

typedef struct program {
    int exit_code; // -1 where a signal ended it
    char *out;     // it and err last until the test ends
    char *err;
} program;

// arguments is a shell's text: "run scene.lua -n 10". The environment's
// DUET_PROGRAM says where the program is.
program program_run(const char *arguments, ...) __attribute__((format(printf, 1, 2)));

// The same with the environment's variables set before: "OCL_ICD_VENDORS=none".
program program_run_with(const char *variables, const char *arguments, ...)
    __attribute__((format(printf, 2, 3)));

program program_run_list(const char *variables, const char *arguments, va_list args);

// Fails the test unless the program ended with 0. Returns it.
program program_done(program p);

// Fails the test unless the program ended so, with nothing on stdout and one
// line on stderr that says it.
void program_assert_refused(program p, int exit_code, const char *says);

// Fails the test unless each row's command line, between `before` and `after`, is refused so;
// prints them.
typedef struct program_refusal {
    const char *arguments;
    int exit_code;
    const char *says;
} program_refusal;

void program_assert_each_refused(const char *before, const char *after, const program_refusal *rows,
                                 size_t n);
#define program_assert_refusals(before, after, rows) \
    program_assert_each_refused(before, after, rows, sizeof(rows) / sizeof *(rows))

// The same of {arguments, says}, all of that exit code.
#define program_assert_refused_by(code, rows)                     \
    for (size_t i_ = 0; i_ < sizeof(rows) / sizeof *(rows); ++i_) \
    program_assert_each_refused("", "",                           \
                                &(const program_refusal){(rows)[i_][0], code, (rows)[i_][1]}, 1)

// Starts the program, whose stdout nobody reads, and whose stderr goes to a file. Returns its
// process, for which the caller waits.
pid_t program_start(const char *err, const char *arguments);

// Skip the test with a line if there is no program of that name beside it, which is built with
// `what` alone.
void skip_without(const char *name, const char *what);
void skip_without_mpi(void);

#endif
