// SPDX-License-Identifier: MIT
// The program at a terminal: Ctrl-C, and the line that tells how far long work is.
//
// A shell runs on a pseudo terminal of its own, and this program types.
#define _GNU_SOURCE
#include "support/json.h"
#include "support/test.h"

#include "base/text_file.h"

#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define CTRL_C "\003"

// The text on the terminal until it closes. Types CTRL_C once `sign` was seen, and `after` seconds
// later; or sends the signal to the shell's process alone.
typedef struct terminal {
    text seen;
    int status;           // the shell's status, as waitpid gives it
    double stopped_after; // seconds from Ctrl-C to the end
} terminal;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static pid_t open_shell(int columns, const char *script, int *screen)
{
    struct winsize size = {.ws_row = 24, .ws_col = (unsigned short)columns};
    skip_without_terminal();
    fflush(NULL);
    pid_t child = forkpty(screen, NULL, NULL, &size);
    assert_true(child >= 0);
    if (child == 0) {
        signal(SIGINT, SIG_DFL);
        execlp("bash", "bash", "-c", script, (char *)NULL);
        _exit(127);
    }
    return child;
}

static terminal run_until(int columns, const char *script, const char *sign, double after,
                          bool alone)
{
    enum { PATIENCE_S = 600 }; // kernels may have to be compiled
    int screen;
    terminal t = {.seen = {0}};
    double begun = now_s(), typed = 0, due = 0;
    pid_t child = open_shell(columns, script, &screen);
    for (;;) {
        struct pollfd in = {.fd = screen, .events = POLLIN};
        char bytes[4096];
        ssize_t n = poll(&in, 1, 50) > 0 ? read(screen, bytes, sizeof bytes) : 0;
        if (n < 0 || now_s() - begun > PATIENCE_S)
            break;
        text_add_bytes(&t.seen, bytes, (size_t)n);
        if (sign && due == 0 && strstr(text_chars(&t.seen), sign))
            due = now_s() + after;
        if (due > 0 && typed == 0 && now_s() >= due) {
            typed = now_s();
            assert_true(alone ? kill(child, SIGINT) == 0 : write(screen, CTRL_C, 1) == 1);
        }
    }
    close(screen);
    assert_int_equal(waitpid(child, &t.status, 0), child);
    t.stopped_after = now_s() - typed;
    if (sign && typed == 0)
        fail_msg("'%s' was not seen in\n%s", sign, text_chars(&t.seen));
    return t;
}

static terminal run_at_terminal(int columns, const char *script, const char *sign, double after)
{
    return run_until(columns, script, sign, after, false);
}

static bool sees(const terminal *t, const char *words)
{
    return strstr(text_chars(&t->seen), words);
}

// ---------------------------------------------------------------- Ctrl-C

// Each would take minutes; what it says at its begin is awaited.
TEST(ctrl_c_ends_a_loop_of_commands_in_bash)
{
    static const struct {
        const char *command;
        const char *sign;
    } long_ones[] = {
        {"run orbit2d -n 200 --steps 1000000000", "energy"},
        {"lua --trust -e 'print(\"begins\") while true do end'", "begins"},
        {"lua --trust -e 'print(\"begins\") io.stdout:flush() os.execute(\"sleep 60\")'", "begins"},
        {"lua --trust -e 'print(\"begins\") io.stdout:flush(); "
         "(\"a\"):rep(40):find((\"a*\"):rep(40) .. \"b\")'",
         "begins"},
        {"run - --pairs out.csv", "begins"},
        {"picture paper -n 4M -o out.svg", "begins"},
        {"accuracy planes -n 20000 --repeat 100", "begins"},
        {"explain orbit2d -n 200 --measure --steps 100000", "begins"},
        {"bench --quick --repeat 100 -o out.json", "begins"},
    };
    remove("out.csv");
    remove("out.svg");
    for (size_t i = 0; i < sizeof long_ones / sizeof *long_ones; ++i) {
        char script[512];
        snprintf(script, sizeof script,
                 "for i in 1 2; do echo begins $i; %s %s; echo goes on; done; echo the end",
                 getenv("DUET_PROGRAM"), long_ones[i].command);
        terminal t = run_at_terminal(100, script, long_ones[i].sign, 0.7);
        if (sees(&t, "goes on") || sees(&t, "the end") || t.stopped_after > 60)
            fail_msg("%s: %s", long_ones[i].command, text_chars(&t.seen));
        assert_true(WIFSIGNALED(t.status) && WTERMSIG(t.status) == SIGINT);
        print_message("%s: %.2f s\n", long_ones[i].command, t.stopped_after);
        text_free(&t.seen);
    }
    assert_int_not_equal(access("out.csv", F_OK), 0);
    assert_int_not_equal(access("out.svg", F_OK), 0);
}

// The ranks of mpirun are told of by mpirun; this rank is alone.
TEST(a_single_rank_tells_that_it_was_stopped)
{
    char script[512];
    snprintf(script, sizeof script, "%s-cluster", getenv("DUET_PROGRAM"));
    if (access(script, X_OK) != 0)
        skip(); // built without MPI
    snprintf(script, sizeof script, "echo begins; exec %s cluster paper -n 8M",
             getenv("DUET_PROGRAM"));
    terminal t = run_at_terminal(100, script, "begins", 0.7);
    if (!sees(&t, "duet: stopped"))
        fail_msg("%s", text_chars(&t.seen));
    text_free(&t.seen);
}

// Ranks are stopped once the first step was timed, however long that takes. A signal to all
// reaches mpirun, too, which may end the ranks before they tell.
TEST(ctrl_c_shows_what_ranks_timed)
{
    static const struct {
        const char *arguments;
        bool alone;
    } runs[] = {{"", true}, {"--ranks 2", true}, {"--ranks 2", false}};
    skip_without_mpi();
    for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
        char script[512];
        snprintf(script, sizeof script,
                 "exec %s cluster %s --plain still -n 300 --repeat 100000 --json >stopped.json",
                 getenv("DUET_PROGRAM"), runs[i].arguments);
        terminal t = run_until(100, script, " a second", 0, runs[i].alone);
        text out = test_read_file("stopped.json");
        if (!sees(&t, "duet: stopped") || (runs[i].alone && out.length == 0))
            fail_msg("%s: %s", script, text_chars(&t.seen));
        if (out.length > 0) {
            const cJSON *o = json_of(text_chars(&out));
            double n = json_number(o, "repeat");
            assert_true(n > 0 && n < 100000 && json_number(o, "total_ms") > 0);
        }
        text_free(&t.seen);
    }
    remove("stopped.json");
}

// ---------------------------------------------------------------- progress

// The longest line that was drawn, without what moves the cursor.
static size_t widest(const char *seen)
{
    size_t most = 0;
    while (*seen) {
        size_t n = strcspn(seen, "\r\n\033");
        most = n > most ? n : most;
        seen += n;
        seen += *seen == '\033' ? strspn(seen, "\033[K") : strspn(seen, "\r\n");
    }
    return most;
}

// A command with its size; `says` is in its progress.
typedef struct work {
    const char *command;
    int size;
    const char *says;
} work;

// How long a work takes is the machine's: one that ends before it says a thing is made
// larger until it says it.
static terminal run_until_told(const work *w, int columns)
{
    enum { LARGER_MOST = 16 };
    for (int larger = 1;; larger *= 4) {
        char command[256];
        char script[512];
        snprintf(command, sizeof command, w->command, w->size * larger);
        snprintf(script, sizeof script, "%s %s", getenv("DUET_PROGRAM"), command);
        terminal t = run_at_terminal(columns, script, NULL, 0);
        bool told = sees(&t, w->says) && (columns < 80 || sees(&t, " left"));
        if (!WIFEXITED(t.status) || WEXITSTATUS(t.status) != 0 || (!told && larger == LARGER_MOST))
            fail_msg("%s: %d, '%s' in\n%s", command, t.status, w->says, text_chars(&t.seen));
        if (told)
            return t;
        text_free(&t.seen);
    }
}

TEST(long_work_tells_how_far_it_is)
{
    static const work works[] = {
        {"run orbit2d -n 300 --steps %d --json >out", 150, " of "},
        {"run paper -n %d --pairs out --repeat 1 --check", 100000, "reference"},
        {"run paper -n %d --repeat 1", 100000, "reading paper"},
        {"picture paper -n %d -o out.svg", 250000, "reference"},
        {"explain orbit2d -n 200 --measure --steps %d --json >out", 20, "step "},
        {"bench --quick --repeat %d --scene planes -o out", 6, "; step "},
        {"accuracy planes -n %d --repeat 9", 2000, "step "},
    };
    for (size_t i = 0; i < sizeof works / sizeof *works; ++i) {
        terminal t = run_until_told(&works[i], 100);
        text_free(&t.seen);
    }
}

// The first of many steps, in which kernels are compiled, says nothing of the others.
TEST(no_time_is_said_to_be_left_after_one_step_of_many)
{
    char script[512];
    snprintf(script, sizeof script, "%s run orbit2d -n 300 --steps 4000 --json >out",
             getenv("DUET_PROGRAM"));
    terminal t = run_at_terminal(100, script, NULL, 0);
    const char *first = strstr(text_chars(&t.seen), "step 1 of 4000, ");
    assert_non_null(first);
    assert_null(memmem(first, strcspn(first, "\r"), " left", 5));
    text_free(&t.seen);
}

TEST(a_task_that_is_checked_says_so)
{
    char script[512];
    snprintf(script, sizeof script,
             "%s run --task %s/../../examples/tasks/saxpy.task.lua --json >out",
             getenv("DUET_PROGRAM"), getenv("DUET_TEST_DATA"));
    terminal t = run_at_terminal(100, script, NULL, 0);
    assert_true(sees(&t, "checking the kernel"));
    text_free(&t.seen);
}

TEST(a_line_of_progress_is_no_wider_than_the_terminal)
{
    enum { COLUMNS = 20 };
    static const work works[] = {
        {"run orbit2d -n 300 --steps %d --json >out", 150, "step "},
        {"tune still -n %d --variants simd --profile out.db --json >out", 300, "1/1 still"},
    };
    for (size_t i = 0; i < sizeof works / sizeof *works; ++i) {
        terminal t = run_until_told(&works[i], COLUMNS);
        if (widest(text_chars(&t.seen)) >= COLUMNS)
            fail_msg("%s", text_chars(&t.seen));
        text_free(&t.seen);
    }
}

TEST(tables_are_folded_to_the_terminal)
{
    enum { COLUMNS = 80 };
    static const char *const commands[] = {"explain paper -n 100", "explain falling -n 100",
                                           "run --help", "tune --help", "cluster --help"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; ++i) {
        char script[512];
        snprintf(script, sizeof script, "%s %s", getenv("DUET_PROGRAM"), commands[i]);
        terminal t = run_at_terminal(COLUMNS, script, NULL, 0);
        if (widest(text_chars(&t.seen)) > COLUMNS)
            fail_msg("%s", text_chars(&t.seen));
        text_free(&t.seen);
    }
}
