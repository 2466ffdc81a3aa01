// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/program.h"

#include "support/test.h"

#include "base/text_file.h"

#include <sys/wait.h>
#include <unistd.h>

static char *take_file(const char *path)
{
    const text t = test_read_file(path);
    remove(path);
    return t.chars;
}

program program_run_list(const char *variables, const char *format, va_list args)
{
    const char *path = getenv("DUET_PROGRAM");
    if (!path)
        fail_msg("DUET_PROGRAM is not set; ctest sets it");
    char arguments[2048];
    char out[64];
    char err[64];
    own(text) command = {0};
    vsnprintf(arguments, sizeof arguments, format, args);
    snprintf(out, sizeof out, "program.%ld.out", (long)getpid());
    snprintf(err, sizeof err, "program.%ld.err", (long)getpid());
    text_add(&command, "{ %s '%s' %s ; } >%s 2>%s", variables, path, arguments, out, err);
    int status = system(text_chars(&command));
    return (program){
        .exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
        .out = take_file(out),
        .err = take_file(err),
    };
}

program program_run(const char *arguments, ...)
{
    va_list args;
    va_start(args, arguments);
    program p = program_run_list("", arguments, args);
    va_end(args);
    return p;
}

program program_run_with(const char *variables, const char *arguments, ...)
{
    va_list args;
    va_start(args, arguments);
    program p = program_run_list(variables, arguments, args);
    va_end(args);
    return p;
}

program program_done(program p)
{
    if (p.exit_code != 0)
        fail_msg("exit %d: %s", p.exit_code, p.err);
    return p;
}

void program_assert_refused(program p, int exit_code, const char *says)
{
    size_t length = strlen(p.err);
    bool one_line = length > 0 && strchr(p.err, '\n') == p.err + length - 1;
    if (p.exit_code != exit_code || !one_line || *p.out || !strstr(p.err, says))
        fail_msg("exit %d for %d, '%s' for a line with '%s', stdout '%.200s'", p.exit_code,
                 exit_code, p.err, says, p.out);
}

void program_assert_each_refused(const char *before, const char *after, const program_refusal *rows,
                                 size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        print_message("duet %s%s%s\n", before, rows[i].arguments, after);
        program_assert_refused(program_run("%s%s%s", before, rows[i].arguments, after),
                               rows[i].exit_code, rows[i].says);
    }
}

pid_t program_start(const char *err, const char *arguments)
{
    own(text) command = {0};
    text_add(&command, "exec '%s' %s >/dev/null 2>%s", getenv("DUET_PROGRAM"), arguments, err);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execl("/bin/sh", "sh", "-c", text_chars(&command), (char *)NULL);
        _exit(127);
    }
    return child;
}

void skip_without(const char *name, const char *what)
{
    char path[4096];
    const char *duet = getenv("DUET_PROGRAM");
    snprintf(path, sizeof path, "%.*s%s", (int)(strrchr(duet, '/') + 1 - duet), duet, name);
    if (access(path, X_OK) != 0) {
        print_message("%s: Duet was built without %s\n", path, what);
        skip();
    }
}

void skip_without_mpi(void)
{
    skip_without("duet-cluster", "MPI");
}
