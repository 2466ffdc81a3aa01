// SPDX-License-Identifier: MIT
// duet cluster --steps, --checkpoint and --resume as a person runs them: a job of which any rank is
// killed, or which is asked to stop, at any moment, ends soon with one line, and the same command
// goes on bit for bit. --all: far more kills.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/test.h"

#include "base/clock.h"
#include "base/text_file.h"

#include <glob.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#define SCENE "falling -n 150"
#define STEPS 30
#define SAVED "cluster.motion"
#define SAYS "cluster.says"
#define KEPT " --every 3 --checkpoint " SAVED " --resume " SAVED

enum { SAVED_EVERY = 3, KILLS = 2, KILLS_OF_ALL = 50, MOST_RANKS = 5, PAUSE_MS = 5 };
enum { STOPS = 4, STOPS_OF_ALL = 20 };

// A job that has not ended by then hangs; a quiet machine is to see its end sooner.
enum { HANGS_S = 60, SOON_S = 5 };

// ---------------------------------------------------------------- going on

TEST(steps_are_the_step_that_a_job_ends_at)
{
    char right[32], hash[32];
    double steps;
    get_hash("run " SCENE " --steps 20 --json", right, &steps);
    get_hash("cluster --ranks 3 " SCENE " --steps 8 --json --checkpoint " SAVED, hash, &steps);
    assert_string_not_equal(hash, right);
    get_hash("cluster --ranks 2 " SCENE " --steps 20 --json --resume " SAVED, hash, &steps);
    assert_true(steps == 12);
    assert_string_equal(hash, right);
    get_hash("run " SCENE " --steps 20 --json --resume " SAVED, hash, &steps); // one rank, no job
    assert_true(steps == 12);
    assert_string_equal(hash, right);
    remove(SAVED);
    get_hash("cluster --parts 2 " SCENE " --steps 20 --json" KEPT, hash, &steps);
    assert_string_equal(hash, right);
    get_hash("cluster --ranks 2 " SCENE " --steps 20 --json" KEPT, hash, &steps); // nothing is left
    assert_true(steps == 0);
    assert_string_equal(hash, right);
    program_assert_refused(program_run("cluster --ranks 2 " SCENE " --steps 19 --resume " SAVED), 2,
                           "--steps 19: " SAVED " was saved at step 20");
    program_assert_refused(program_run("cluster --ranks 2 " SCENE " --steps 30 --resume no.motion"),
                           1, "no.motion: No such file");
    program_assert_refused(program_run("cluster --ranks 2 " SCENE
                                       " --steps 30 --checkpoint other.motion --resume no.motion"),
                           1, "no.motion: No such file");
    remove(SAVED);
}

// ---------------------------------------------------------------- killed ranks

// Children of all threads; a process that has ended has none.
static int children_of(pid_t process, pid_t children[MOST_RANKS])
{
    char pattern[64];
    glob_t tasks;
    int n = 0;
    snprintf(pattern, sizeof pattern, "/proc/%ld/task/*/children", (long)process);
    if (glob(pattern, 0, NULL, &tasks) != 0)
        return 0;
    for (size_t i = 0; i < tasks.gl_pathc; ++i) {
        FILE *f = fopen(tasks.gl_pathv[i], "r");
        for (long child; f && n < MOST_RANKS && fscanf(f, "%ld", &child) == 1;)
            children[n++] = (pid_t)child;
        if (f)
            fclose(f);
    }
    globfree(&tasks);
    return n;
}

// The ranks are children of mpirun, which is the program's child.
static int ranks_of(pid_t job, pid_t ranks[MOST_RANKS])
{
    pid_t mpirun[MOST_RANKS];
    return children_of(job, mpirun) > 0 ? children_of(mpirun[0], ranks) : 0;
}

static void pause_ms(uint64_t ms)
{
    const struct timespec delay = {(time_t)(ms / 1000), (long)(ms % 1000 * 1000000)};
    nanosleep(&delay, NULL);
}

static bool has_ended(pid_t job, int *status)
{
    pid_t ended = waitpid(job, status, WNOHANG);
    assert_true(ended >= 0);
    return ended == job;
}

// Whether a process is a rank with a handler of SIGTERM, which would else end it. mpirun's child
// has mpirun's handler until it becomes a rank.
static bool hears(pid_t process)
{
    char path[64], line[128], name[16] = "";
    unsigned long long caught = 0;
    snprintf(path, sizeof path, "/proc/%ld/status", (long)process);
    FILE *f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f)) {
        sscanf(line, "Name: %15s", name);
        sscanf(line, "SigCgt: %llx", &caught);
    }
    if (f)
        fclose(f);
    return strcmp(name, "duet-cluster") == 0 && caught >> (SIGTERM - 1) & 1;
}

static bool all_hear(pid_t job, int n_ranks, pid_t ranks[MOST_RANKS])
{
    bool all = ranks_of(job, ranks) >= n_ranks;
    for (int i = 0; all && i < n_ranks; ++i)
        all = hears(ranks[i]);
    return all;
}

// Waits until all ranks are there, and so many ms more. Returns false if the job was done before.
static bool wait_for(pid_t job, int n_ranks, uint64_t after_ms, pid_t ranks[MOST_RANKS],
                     int *status)
{
    while (!all_hear(job, n_ranks, ranks)) {
        if (has_ended(job, status))
            return false;
        pause_ms(PAUSE_MS);
    }
    for (uint64_t ms = 0; ms < after_ms; ms += PAUSE_MS) {
        if (has_ended(job, status))
            return false;
        pause_ms(PAUSE_MS);
    }
    return true;
}

// Returns how long a job goes on from now.
static double time_end(pid_t job, int *status)
{
    uint64_t asked = clock_steady_ns();
    while (!has_ended(job, status) && clock_ms_since(asked) < 1e3 * HANGS_S)
        pause_ms(PAUSE_MS);
    double took_s = 1e-3 * clock_ms_since(asked);
    if (took_s >= HANGS_S)
        kill(job, SIGKILL);
    assert_true(took_s < (test_takes_all() ? SOON_S : HANGS_S));
    return took_s;
}

static void wait_for_end(pid_t job, int *status)
{
    while (!WIFEXITED(*status) && !has_ended(job, status))
        pause_ms(PAUSE_MS);
}

// Lines of mpirun itself pass through; they begin with "[", as [warn] of libevent or [HOST:PID].
static void must_say_one_line(void)
{
    const text says = test_read_file(SAYS);
    int n = 0;
    for (const char *line = text_chars(&says), *end; *line; line = end + 1) {
        end = strchr(line, '\n');
        const bool is_ours = strncmp(line, "duet: ", 6) == 0;
        n += is_ours;
        if (!end || (!is_ours && *line != '[' && *line != '\n'))
            fail_msg("other than one line: %s", text_chars(&says));
    }
    assert_int_equal(n, 1);
}

// Returns how long a job that lost a rank went on; -1: it was done before.
static double run_and_kill(const char *arguments, int n_ranks, rng *r, uint64_t after_ms)
{
    int status = 0;
    pid_t ranks[MOST_RANKS], job = program_start(SAYS, arguments);
    if (!wait_for(job, n_ranks, after_ms, ranks, &status) ||
        kill(ranks[rng_below(r, (uint32_t)n_ranks)], SIGKILL) != 0) {
        wait_for_end(job, &status); // its ranks have ended
        return -1;
    }
    double took_s = time_end(job, &status);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == 0)
        return -1; // it had written all that it was to
    assert_int_equal(WEXITSTATUS(status), 1);
    must_say_one_line();
    return took_s;
}

// Jobs that ended because they were told to.
typedef struct ended {
    int n;
    double slowest_s;
} ended;

// Counts a job that went on so long; below 0: it was done before, and begins again.
static void note_end(ended *all, double took_s)
{
    all->n += took_s >= 0;
    all->slowest_s = took_s > all->slowest_s ? took_s : all->slowest_s;
    if (took_s < 0)
        remove(SAVED);
}

TEST(a_job_that_loses_a_rank_at_any_moment_ends_soon_and_goes_on_bit_for_bit)
{
    char job[128], right[32], hash[32];
    double steps;
    ended killed = {0};
    int kills = test_takes_all() ? KILLS_OF_ALL : KILLS;
    rng r = rng_seed(test_seed());
    snprintf(job, sizeof job, SCENE " --steps %d --json", STEPS);
    char whole[320];
    snprintf(whole, sizeof whole, "run %s", job);
    get_hash(whole, right, &steps);
    uint64_t begun = clock_steady_ns();
    snprintf(whole, sizeof whole, "cluster --ranks 3 %s" KEPT, job);
    remove(SAVED);
    get_hash(whole, hash, &steps);
    double took_ms = clock_ms_since(begun);
    assert_string_equal(hash, right);
    remove(SAVED);
    while (killed.n < kills) {
        int n_ranks = 2 + (int)rng_below(&r, MOST_RANKS - 1);
        snprintf(whole, sizeof whole, "cluster --ranks %d %s" KEPT, n_ranks, job);
        double s = run_and_kill(whole, n_ranks, &r, (uint64_t)(took_ms * rng_unit(&r)));
        note_end(&killed, s);
    }
    print_message("%d ranks were killed; the slowest job ended %.2f s later\n", killed.n,
                  killed.slowest_s);
    get_hash(whole, hash, &steps);
    assert_string_equal(hash, right);
    assert_true(steps <= STEPS && (STEPS - (int)steps) % SAVED_EVERY == 0); // from a checkpoint
    remove(SAVED);
    remove(SAYS);
}

// ---------------------------------------------------------------- jobs that are asked to stop

// Returns how long a job goes on that was asked to stop, and ends by that signal; -1: it was done
// before.
static double time_stop(pid_t job, int number)
{
    int status = 0;
    double took_s = time_end(job, &status);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return -1;
    const text says = test_read_file(SAYS);
    assert_string_equal(text_chars(&says), "duet: stopped\n");
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), number);
    return took_s;
}

// Sends a signal to the program or to its mpirun. Returns what time_stop does. A program ends by
// SIGINT if another process was asked.
static double run_and_stop(const char *arguments, int n_ranks, uint64_t after_ms, int number,
                           bool to_mpirun)
{
    int status = 0;
    pid_t ranks[MOST_RANKS], mpirun[MOST_RANKS], job = program_start(SAYS, arguments);
    if (!wait_for(job, n_ranks, after_ms, ranks, &status) || children_of(job, mpirun) == 0 ||
        kill(to_mpirun ? mpirun[0] : job, number) != 0) {
        wait_for_end(job, &status);
        return -1;
    }
    return time_stop(job, to_mpirun ? SIGINT : number);
}

// Whether it waits for its parent to notice that it has ended, or is gone.
static bool is_done(pid_t process)
{
    char path[64], state = 'Z';
    snprintf(path, sizeof path, "/proc/%ld/stat", (long)process);
    FILE *f = fopen(path, "r");
    if (f && fscanf(f, "%*d (%*[^)]) %c", &state) != 1)
        state = 'Z';
    if (f)
        fclose(f);
    return state == 'Z';
}

// Ranks are done some milliseconds before mpirun; if that is done, too, another job is asked.
TEST(a_job_whose_mpirun_is_asked_once_its_ranks_are_done_is_stopped)
{
    for (double took_s = -1; took_s < 0;) {
        int status = 0;
        pid_t ranks[MOST_RANKS], mpirun[MOST_RANKS];
        pid_t job = program_start(SAYS, "cluster --ranks 2 " SCENE " --steps 1 --json");
        if (!wait_for(job, 2, 0, ranks, &status) || children_of(job, mpirun) == 0) {
            wait_for_end(job, &status);
            continue;
        }
        while (!is_done(ranks[0]) || !is_done(ranks[1]))
            pause_ms(1);
        kill(mpirun[0], SIGTERM);
        took_s = time_stop(job, SIGINT);
    }
    remove(SAYS);
}

TEST(a_job_that_is_asked_to_stop_at_any_moment_ends_soon_and_goes_on_bit_for_bit)
{
    char right[32], hash[32], job[320];
    double steps;
    ended stopped = {0};
    int stops = test_takes_all() ? STOPS_OF_ALL : STOPS;
    rng r = rng_seed(test_seed());
    get_hash("run " SCENE " --steps 30 --json", right, &steps);
    const uint64_t begun = clock_steady_ns();
    remove(SAVED);
    get_hash("cluster --ranks 3 " SCENE " --steps 30 --json" KEPT, hash, &steps);
    const double took_ms = clock_ms_since(begun);
    remove(SAVED);
    while (stopped.n < stops) {
        int n_ranks = 2 + (int)rng_below(&r, 2), number = stopped.n & 1 ? SIGTERM : SIGINT;
        snprintf(job, sizeof job, "cluster --ranks %d " SCENE " --steps 30 --json" KEPT, n_ranks);
        double s =
            run_and_stop(job, n_ranks, (uint64_t)(took_ms * rng_unit(&r)), number, stopped.n & 2);
        note_end(&stopped, s);
    }
    print_message("%d jobs were stopped; the slowest ended %.2f s later\n", stopped.n,
                  stopped.slowest_s);
    get_hash(job, hash, &steps);
    assert_string_equal(hash, right);
    remove(SAVED);
    remove(SAYS);
}
