// SPDX-License-Identifier: MIT
// duet lua: runs scripts that use the module `duet`, or what a person types.
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/output.h"
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/options.h"
#include "cli/say.h"
#include "lua/session.h"
#include "runtime/duet.h"

#include <editline/readline.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct arguments {
    const char *code;
    bool interactive;
    bool trust;
    uint64_t memory_mib;
    double seconds;
} arguments;

static const option options[] = {
    OPTION_TEXT("eval", code, "CODE", "run this text, before FILE"),
    OPTION_FLAG("interactive", interactive, "run what is typed, after FILE; Ctrl-D ends"),
    OPTION_FLAG("trust", trust, "allow the whole language: files, processes, modules, no limits"),
    OPTION_COUNT("memory", memory_mib, "MIB", "memory of a script without --trust (256)", 1,
                 1 << 20),
    OPTION_NUMBER("seconds", seconds, "S", "time of a script without --trust (60)", 0.001, 1e6),
    {0},
};

static const option_rule rules[] = {{"memory seconds", OPTION_EXCLUDES, "trust"}, {0}};

static const command_line line = {
    .name = "lua",
    .operands = "[FILE [ARGUMENT...]]",
    .rest_is_operands = true,
    .about = "Runs a Lua script that uses the module 'duet'; its arguments are in 'arg'.\n"
             "Runs what is typed if there is neither FILE nor CODE; 'help' there says how to\n"
             "begin. A script without --trust can compute, print and use devices, read files\n"
             "below the current folder or named as arguments, and change nothing.",
    .options = options,
    .rules = rules,
};

// ---------------------------------------------------------------- the prompt

static bool is_terminal(void)
{
    return isatty(STDIN_FILENO) && isatty(STDOUT_FILENO);
}

enum { HISTORY_LINES = 1000 };

// The session whose names Tab completes; libedit's calls cannot carry it.
static session *completing;

// The next name of the list, for libedit to free; NULL after the last.
static char *next_name(const char *word, int n)
{
    static text names;
    static char *at;
    if (n == 0) {
        text_free(&names);
        at = session_complete(completing, word, &names) ? names.chars : NULL;
    }
    size_t length = at ? strcspn(at, "\n") : 0;
    if (length == 0)
        return NULL;
    char *name = strndup(at, length);
    at += length + (at[length] == '\n');
    return name;
}

static char **complete(const char *word, int start, int end)
{
    (void)start;
    (void)end;
    rl_attempted_completion_over = 1; // no names of files
    rl_completion_append_character = '\0';
    return rl_completion_matches(word, next_name);
}

// The file that keeps typed lines between sessions; empty if there is no place for one.
static void find_history(text *path)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *home = getenv("HOME");
    if (state && *state == '/')
        text_add(path, "%s/duet/lua_history", state);
    else if (home && *home == '/')
        text_add(path, "%s/.local/state/duet/lua_history", home);
    if (path->length > 0)
        output_make_folders(path->chars, 0700, NULL);
}

// If the history cannot be written, nothing is said: a person can work without it.
static void begin_typing(session *s, text *history_path)
{
    if (!is_terminal())
        return;
    completing = s;
    rl_readline_name = "duet";
    rl_attempted_completion_function = complete;
    rl_basic_word_break_characters = " \t\n\"'=<>~+-*/%^#&|(){}[];,";
    using_history();
    stifle_history(HISTORY_LINES);
    find_history(history_path);
    if (text_ok(history_path, NULL) && history_path->chars)
        read_history(history_path->chars);
}

static void end_typing(const text *history_path)
{
    if (is_terminal() && text_ok(history_path, NULL) && history_path->chars)
        write_history(history_path->chars);
}

// The next line without its end, given back by free; NULL at the end, and where Ctrl-C
// dropped what was typed. A file or a pipe gets no prompt.
static char *read_line(const char *prompt, bool *dropped)
{
    *dropped = false;
    if (is_terminal()) {
        interrupt_forget();
        interrupt_pass(true);
        char *line_typed = readline(prompt);
        interrupt_pass(false);
        *dropped = !line_typed && interrupt_asked();
        interrupt_forget();
        return line_typed;
    }
    char *typed = NULL;
    size_t capacity = 0;
    ssize_t length = getline(&typed, &capacity, stdin);
    if (length < 0) {
        free(typed);
        return NULL;
    }
    if (length > 0 && typed[length - 1] == '\n')
        typed[length - 1] = '\0';
    return typed;
}

// Keeps the line for the arrow keys.
static void remember(const char *typed)
{
    if (*typed && is_terminal())
        add_history(typed);
}

// Reads until what was typed is whole. NULL at the end.
static char *read_typed(session *s, duet_error *err, bool *ran)
{
    text typed = {0};
    bool more = true;
    *ran = true;
    while (more) {
        bool dropped;
        char *next = read_line(typed.length > 0 ? ">> " : "> ", &dropped);
        if (dropped) {
            putchar('\n');
            text_free(&typed);
            return strdup("");
        }
        if (!next)
            break;
        text_add(&typed, "%s%s", typed.length > 0 ? "\n" : "", next);
        free(next);
        *ran = session_enter(s, text_chars(&typed), &more, err);
    }
    if (more && typed.length == 0) {
        text_free(&typed);
        return NULL;
    }
    if (more)
        *ran = bad_input(err, "typed: ends in the middle: %s", text_chars(&typed));
    return typed.chars;
}

// A person sees an error and goes on; a pipe ends with the first one.
static bool read_all(session *s, duet_error *err)
{
    for (;;) {
        bool ran = true;
        duet_error why = {0};
        char *typed = read_typed(s, &why, &ran);
        if (!typed)
            return true;
        remember(typed);
        free(typed);
        fflush(stdout);
        if (!ran && !is_terminal()) {
            *err = why;
            return false;
        }
        if (!ran)
            say_failed(&why);
    }
}

static bool talk(session *s, duet_error *err)
{
    text history_path = {0};
    begin_typing(s, &history_path);
    if (is_terminal()) {
        interrupt_react(INTERRUPT_INTERACTIVE);
        printf("duet %s, Lua 5.4; help says how to begin, Ctrl-D ends\n", duet_version());
    }
    bool ok = read_all(s, err);
    end_typing(&history_path);
    text_free(&history_path);
    return ok;
}

// ---------------------------------------------------------------- the command

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    int n = 0;
    while (operands[n])
        ++n;
    bool typed = args->interactive || (n == 0 && !args->code);
    session_def def = session_default_def();
    def.trusted = args->trust;
    if (args->trust)
        interrupt_pass(true); // it may start processes, which are to hear of Ctrl-C
    def.prompt = typed;
    def.memory_bytes = (size_t)args->memory_mib << 20;
    def.seconds = args->seconds;
    def.arguments = (const char *const *)operands;
    def.n_arguments = n;
    session *s = session_open(&def, err);
    bool ok = s != NULL;
    ok = ok && (!args->code || session_run_text(s, "-e", args->code, err));
    ok = ok && (n == 0 || session_run_file(s, operands[0], err));
    ok = ok && (!typed || talk(s, err));
    session_close(s);
    return ok;
}

SUBCOMMAND(lua, .memory_mib = 256, .seconds = 60)
