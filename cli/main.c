// SPDX-License-Identifier: MIT
// The program `duet`: finds the subcommand and ends with its exit status,
// which is 0 if it did what was asked, 1 if that failed, and 2 if the
// command line was wrong. Once a signal has asked it to stop it ends by that signal, which a shell
// shows as 130 (SIGINT, Ctrl-C), 143 (SIGTERM) or 129 (SIGHUP).
#define _POSIX_C_SOURCE 200809L
#include "base/nearest.h"
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "runtime/duet.h"

#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *about;
} commands[] = {
#define ROW(name, about) {#name, command_##name, about},
    COMMANDS(ROW)};

enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

static void print_help(void)
{
    printf("duet %s: collisions among boxes, found by two OpenCL devices together\n\n"
           "duet SUBCOMMAND [arguments]\n\n",
           duet_version());
    for (int i = 0; i < N_COMMANDS; ++i)
        printf("  %-10s %s\n", commands[i].name, commands[i].about);
    printf("\n'duet SUBCOMMAND --help' lists its options.\n\n"
           "DUET_PAIR        devices without --pair, as --pair takes them\n"
           "DUET_PROFILE     the profile file\n"
           "DUET_WAIT        seconds that a tuning waits for other programs, as with --wait\n"
           "DUET_KERNEL_DIR  folder to read kernels from, instead of the built-in ones\n"
           "DUET_CACHE       folder that keeps built kernels, or off\n\n"
           "exit status: 0 done, 1 failed (or 'bench --against': slower), 2 wrong usage, "
           "130 interrupted\n");
}

static int refuse(const char *name)
{
    nearest n = nearest_begin(name);
    for (int i = 0; i < N_COMMANDS; ++i)
        nearest_try(&n, commands[i].name);
    fprintf(stderr, "duet: there is no subcommand '%s'; ", say_name(name).chars);
    fprintf(stderr, n.name ? "did you mean '%s'?\n" : "'duet --help' lists those there are\n",
            n.name);
    return EXIT_WRONG;
}

static int run_command(const char *name, int argc, char **argv)
{
    for (int i = 0; i < N_COMMANDS; ++i)
        if (strcmp(name, commands[i].name) == 0)
            return commands[i].run(argc, argv);
    return refuse(name);
}

static int help_with(char *name)
{
    char help[] = "--help";
    char *argv[] = {name, help, NULL};
    return run_command(name, 2, argv);
}

static int refuse_more(const char *argument)
{
    fprintf(stderr, "duet: unexpected argument '%s'; 'duet --help' shows the form\n",
            say_name(argument).chars);
    return EXIT_WRONG;
}

// "--help", "--help NAME", "--version"; false if the name is a subcommand's.
static bool run_option(int argc, char **argv, int *status)
{
    const char *name = argv[1];
    bool asks = strcmp(name, "help") == 0 || strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0;
    int most = asks ? 3 : 2;
    if (!asks && strcmp(name, "--version") != 0)
        return false;
    *status = EXIT_OK;
    if (argc > most)
        *status = refuse_more(argv[most]);
    else if (!asks)
        printf("duet %s\n", duet_version());
    else if (argc == most)
        *status = help_with(argv[2]);
    else
        print_help();
    return true;
}

static int run(int argc, char **argv)
{
    if (argc < 2) {
        print_help();
        printf("\n");
        fflush(stdout);
        fprintf(stderr, "duet: a subcommand is missing\n");
        return EXIT_WRONG;
    }
    int status;
    return run_option(argc, argv, &status) ? status : run_command(argv[1], argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    setlocale(LC_CTYPE, "");  // only to know whether bars may be drawn finely
    signal(SIGXFSZ, SIG_IGN); // a write that fails is told of by a line
    interrupt_watch();
    int status = run(argc, argv);
    bool written = say_finish();
    if (status == EXIT_INTERRUPTED)
        interrupt_end();
    return status == EXIT_OK && !written ? EXIT_FAILED : status;
}
