// SPDX-License-Identifier: MIT
// Open MPI is told by its variables, which mean nothing under another MPI, how ranks are started.
#define _GNU_SOURCE // environ, pipe2
#include "cli/mpirun.h"

#include "base/clock.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/say.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PAUSE_MS = 20, START_S = 60, LAST_SIGNAL = 31 };
enum { TELLS_DONE = 1 }; // to the socket; 0: asked to stop

#define STOP_NS 2500000000u       // given to ranks that are asked to stop
#define STOP_GRACE_NS 1500000000u // then to mpirun to end them, which was asked to
#define GRACE_NS 5000000000u      // likewise where ranks do not begin
#define STUCK_NS 3000000000u      // given to mpirun to notice that all that it started has ended

typedef enum line_state { LINE_BEGINS, LINE_PASSES, LINE_DROPPED } line_state;

// The latest that ranks have told the socket: a later state hides those before.
typedef enum told_state {
    TOLD_NOTHING,
    TOLD_DONE,  // a rank is done
    TOLD_ASKED, // a signal asks a rank to stop
} told_state;

typedef struct job {
    const mpirun_job *what;
    bool begun;   // all ranks are there
    bool stopped; // they have stopped, because one was asked to
    told_state told_by_ranks;
    pid_t mpirun;
    int err_pipe;      // its stderr; -1: closed
    line_state line;   // of what mpirun and the ranks write
    bool told;         // a line of Duet has passed
    int asked;         // a socket: ranks write there that they were asked to stop; -1: none
    int status;        // that waitpid tells
    uint64_t start_ns; // by when ranks are to have begun; 0: there is no limit
    uint64_t stop_ns;  // when ranks were asked to stop; 0: not
    uint64_t asked_ns; // when it was asked to end; 0: not
    uint64_t alone_ns; // since when all that it started has ended; 0: not so
    unsigned long patience_s;
} job;

// ---------------------------------------------------------------- its variables

// Settings of mpirun that the user can override. Open MPI 5 has new names for all but one.
static const char *const variables[][2] = {
    // Ranks share the machine: by itself mpirun gives each one core, and refuses more of them than
    // there are.
    {"OMPI_MCA_hwloc_base_binding_policy", "none"},
    {"PRTE_MCA_hwloc_default_binding_policy", "none"},
    {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
    {"PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"},
    {"OMPI_MCA_mpi_yield_when_idle", "1"},
    // Else mpirun lists OpenCL's devices, and a loader that it calls for that cuts
    // OCL_ICD_FILENAMES in the environment, which the ranks inherit, after its first driver.
    {"HWLOC_COMPONENTS", "-opencl"},
    // A machine that is out of reach is missed within 3 s, and not within minutes.
    {"OMPI_MCA_oob_tcp_keepalive_time", "1"},
    {"OMPI_MCA_oob_tcp_keepalive_intvl", "1"},
    {"OMPI_MCA_oob_tcp_keepalive_probes", "2"},
    {"PRTE_MCA_oob_tcp_keepalive_time", "1"},
    {"PRTE_MCA_oob_tcp_keepalive_intvl", "1"},
    {"PRTE_MCA_oob_tcp_keepalive_probes", "2"},
};

static void prepare(const mpirun_job *what)
{
    if (!what->verbose) { // names of Open MPI 4 and 5
        setenv("OMPI_MCA_orte_execute_quiet", "1", 0);
        setenv("PRTE_MCA_prte_execute_quiet", "1", 0);
    }
    for (size_t i = 0; i < sizeof variables / sizeof *variables; ++i)
        setenv(variables[i][0], variables[i][1], 0);
    setenv(MPIRUN_STARTED, isatty(STDERR_FILENO) ? "terminal" : "pipe", 1);
}

// Reads Open MPI's own setting. Open MPI itself waits for ever for a program such as ssh that
// hangs.
static unsigned long patience_s(void)
{
    const char *given = getenv("OMPI_MCA_orte_startup_timeout");
    return given && *given ? strtoul(given, NULL, 10) : START_S;
}

// ---------------------------------------------------------------- the socket

// Abstract: it is in no folder, and goes with its process.
static socklen_t name_socket(struct sockaddr_un *to, const char *name)
{
    *to = (struct sockaddr_un){.sun_family = AF_UNIX};
    int n = snprintf(to->sun_path + 1, sizeof to->sun_path - 1, "%s", name);
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)n);
}

static int open_socket(void)
{
    return socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

// Without it the job ends with another line.
static void listen_for_ranks(job *j)
{
    struct sockaddr_un own;
    char name[40];
    uint64_t number;
    if (getrandom(&number, sizeof number, GRND_NONBLOCK) != sizeof number)
        return;
    snprintf(name, sizeof name, "duet-cluster-%016" PRIx64, number);
    socklen_t length = name_socket(&own, name);
    j->asked = open_socket();
    if (j->asked >= 0 && bind(j->asked, (struct sockaddr *)&own, length) == 0)
        setenv(MPIRUN_ASKED, name, 1);
}

int mpirun_connect(void)
{
    struct sockaddr_un starter;
    const char *name = getenv(MPIRUN_ASKED);
    if (!name || strlen(name) >= sizeof starter.sun_path - 1)
        return -1;
    int file = open_socket();
    if (file < 0 || connect(file, (struct sockaddr *)&starter, name_socket(&starter, name)) == 0)
        return file;
    close(file);
    return -1;
}

void mpirun_tell_done(int file)
{
    if (file >= 0)
        send(file, (char[]){TELLS_DONE}, 1, 0);
}

// ---------------------------------------------------------------- from begin to end

static bool spawn(job *j, duet_error *err)
{
    posix_spawn_file_actions_t actions;
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(err, DUET_STATUS_IO_FAILED, "mpirun: a pipe: %s", strerror(errno));
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    if (!j->what->reads_stdin)
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (j->what->output)
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, j->what->output,
                                         O_WRONLY | O_CREAT | O_TRUNC, 0666);
    interrupt_pass(true);
    int code = posix_spawnp(&j->mpirun, j->what->argv[0], &actions, NULL, j->what->argv, environ);
    interrupt_pass(false);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    j->err_pipe = ends[0];
    return code == 0 || error_set(err, DUET_STATUS_NOT_FOUND, "mpirun: %s%s", strerror(code),
                                  code == ENOENT ? "; on Debian: apt install openmpi-bin" : "");
}

// Whether it was asked to stop, or a rank was.
static bool is_stopping(const job *j)
{
    return j->stop_ns > 0 || j->stopped || j->told_by_ranks == TOLD_ASKED;
}

// Whether a byte is told. Once the job stops, lines are only told if they are of Duet: mpirun,
// which is then asked to end it, has much to say of that.
static bool passes(job *j, char byte)
{
    if (j->line == LINE_BEGINS) {
        const bool dropped = is_stopping(j) && !j->what->verbose && byte != 'd';
        j->line = dropped ? LINE_DROPPED : LINE_PASSES;
        j->told |= byte == 'd'; // as "duet: "
    }
    const bool passes = j->line == LINE_PASSES;
    if (byte == '\n' || byte == '\r')
        j->line = LINE_BEGINS;
    return passes;
}

// Passes on what mpirun and the ranks write. Returns whether there was something within `wait_ms`.
static bool relay(job *j, int wait_ms)
{
    char bytes[4096];
    struct pollfd from = {.fd = j->err_pipe, .events = POLLIN};
    if (poll(&from, 1, wait_ms) <= 0)
        return false;
    ssize_t n = read(j->err_pipe, bytes, sizeof bytes), passed = 0;
    for (ssize_t i = 0; i < n; ++i) {
        j->begun |= bytes[i] == MPIRUN_BEGUN;
        j->stopped |= bytes[i] == MPIRUN_STOPPED;
        if (bytes[i] != MPIRUN_BEGUN && bytes[i] != MPIRUN_STOPPED && passes(j, bytes[i]))
            bytes[passed++] = bytes[i];
    }
    fwrite(bytes, 1, (size_t)passed, stderr);
    if (n == 0) {
        close(j->err_pipe);
        j->err_pipe = -1;
    }
    return n > 0;
}

// Notes whether a rank told that a signal asks it to stop, or that it is done.
static void note_told(job *j)
{
    for (char told; j->asked >= 0 && recv(j->asked, &told, 1, 0) == 1;) {
        const told_state state = told == TELLS_DONE ? TOLD_DONE : TOLD_ASKED;
        j->told_by_ranks = state > j->told_by_ranks ? state : j->told_by_ranks;
    }
}

// Ranks that are at work tell what they have done; others end.
static void ask_to_stop(job *j)
{
    note_told(j);
    if (j->stop_ns > 0 || !interrupt_asked())
        return;
    kill(j->mpirun, MPIRUN_STOPS);
    j->stop_ns = clock_steady_ns();
}

static void ask_to_end(job *j)
{
    uint64_t now = clock_steady_ns();
    bool late = (j->start_ns > 0 && !j->begun && now > j->start_ns) ||
                (j->stop_ns > 0 && now - j->stop_ns > STOP_NS);
    if (j->asked_ns == 0 && late) {
        kill(j->mpirun, SIGTERM);
        j->asked_ns = now;
    } else if (j->asked_ns > 0 && now - j->asked_ns > (j->stop_ns > 0 ? STOP_GRACE_NS : GRACE_NS)) {
        kill(j->mpirun, SIGKILL);
    }
}

// The children of a process, to be closed; NULL: it has ended.
static FILE *children_of(pid_t process)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%ld/task/%ld/children", (long)process, (long)process);
    return fopen(path, "r");
}

static bool is_zombie(long process)
{
    char path[64], state = 0;
    snprintf(path, sizeof path, "/proc/%ld/stat", process);
    FILE *stat = fopen(path, "r");
    bool read = stat && fscanf(stat, "%*d (%*[^)]) %c", &state) == 1;
    if (stat)
        fclose(stat);
    return read && state == 'Z';
}

// Whether it has children, and all of them ended and wait for it to notice.
static bool has_only_zombies(pid_t process)
{
    long child;
    bool found = false, lives = false;
    FILE *children = children_of(process);
    while (children && !lives && fscanf(children, "%ld", &child) == 1) {
        lives = !is_zombie(child);
        found = true;
    }
    if (children)
        fclose(children);
    return found && !lives;
}

// Open MPI 4.1 can wait for a lock of its own for ever, once a rank was killed.
static void end_if_stuck(job *j)
{
    uint64_t now = clock_steady_ns();
    const bool alone = has_only_zombies(j->mpirun);
    const bool late = j->alone_ns > 0 && now - j->alone_ns > STUCK_NS; // from then on
    if (alone && late)
        kill(j->mpirun, SIGKILL);
    else if (!late && alone != (j->alone_ns > 0))
        j->alone_ns = alone ? now : 0;
}

static bool wait_for(job *j)
{
    pid_t ended;
    while ((ended = waitpid(j->mpirun, &j->status, WNOHANG)) == 0) {
        relay(j, PAUSE_MS);
        ask_to_stop(j);
        ask_to_end(j);
        end_if_stuck(j);
    }
    while (relay(j, 0))
        continue;
    note_told(j); // what was since the last look
    return ended == j->mpirun;
}

// Ends processes that mpirun has left, as an ssh that hangs: they are this process's since then.
// Ranks that were asked to stop, and have not, are in a long step.
static void end_rest(const job *j)
{
    long child;
    FILE *children = children_of(getpid());
    while (children && fscanf(children, "%ld", &child) == 1)
        kill((pid_t)child, is_stopping(j) ? SIGKILL : SIGTERM);
    if (children)
        fclose(children);
}

// ---------------------------------------------------------------- how it ended

static bool fail_by_signal(const job *j, int number, duet_error *err)
{
    return error_set(
        err, DUET_STATUS_IO_FAILED, "a rank was ended by signal %d (%s), and with it the job%s",
        number, strsignal(number), j->what->verbose ? "" : "; with --verbose mpirun says which");
}

// Open MPI refuses root unless both say 1.
static bool is_refused_root(void)
{
    const char *allowed = getenv("OMPI_ALLOW_RUN_AS_ROOT");
    const char *confirmed = getenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM");
    return geteuid() == 0 && (!allowed || !confirmed);
}

static bool fail_by_status(const job *j, int code, duet_error *err)
{
    if (!j->begun && code == EXIT_FAILED && is_refused_root())
        return error_set(err, DUET_STATUS_IO_FAILED,
                         "mpirun ended with status 1: as root set OMPI_ALLOW_RUN_AS_ROOT and "
                         "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM to 1");
    return error_set(err, DUET_STATUS_IO_FAILED, "mpirun ended with status %d%s%s%s", code,
                     j->begun ? "" : " before all ranks had begun",
                     j->what->hosts ? ", a machine may be out of reach" : "",
                     j->what->verbose ? "" : "; with --verbose it says why");
}

// mpirun asks ranks to stop because it was itself, or because it has lost one: its status then says
// how that one ended. Ranks that are done cannot tell that it was asked.
static bool is_mpirun_asked(const job *j)
{
    return j->told_by_ranks != TOLD_NOTHING && WIFEXITED(j->status) &&
           WEXITSTATUS(j->status) == EXIT_FAILED;
}

static bool explain(const job *j, int *status, duet_error *err)
{
    int code = WIFEXITED(j->status) ? WEXITSTATUS(j->status) : 0;
    int told = code == 0 ? EXIT_OK : code - MPIRUN_TOLD;
    *status = EXIT_OK;
    if (interrupt_asked() || j->stopped || is_mpirun_asked(j))
        return error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
    if (j->asked_ns > 0)
        return error_set(err, DUET_STATUS_IO_FAILED,
                         "the ranks on %s have not begun within %lu s; expected machines that ssh "
                         "reaches, and that reach this one",
                         j->what->hosts, j->patience_s);
    if (WIFSIGNALED(j->status) && j->alone_ns > 0 && j->told) {
        *status = EXIT_FAILED;
        return true;
    }
    if (WIFSIGNALED(j->status) && j->alone_ns > 0)
        return error_set(err, DUET_STATUS_IO_FAILED,
                         "the ranks have ended, and mpirun did not: it was ended after %u s",
                         (unsigned)(STUCK_NS / 1000000000u));
    if (WIFSIGNALED(j->status))
        return error_set(err, DUET_STATUS_IO_FAILED, "mpirun was ended by signal %d (%s)",
                         WTERMSIG(j->status), strsignal(WTERMSIG(j->status)));
    if (code > 128 && code <= 128 + LAST_SIGNAL)
        return fail_by_signal(j, code - 128, err);
    if (told != EXIT_OK && told != EXIT_FAILED && told != EXIT_WRONG)
        return fail_by_status(j, code, err);
    *status = told;
    return true;
}

bool mpirun_run(const mpirun_job *what, int *status, duet_error *err)
{
    job j = {.what = what, .asked = -1, .patience_s = patience_s()};
    if (what->hosts && j.patience_s > 0)
        j.start_ns = clock_steady_ns() + j.patience_s * 1000000000u;
    prepare(what);
    listen_for_ranks(&j);
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    interrupt_react(INTERRUPT_AWAITED); // mpirun is given longer to end than this program is
    bool ok = spawn(&j, err) && (wait_for(&j) || error_set(err, DUET_STATUS_IO_FAILED,
                                                           "mpirun is gone: %s", strerror(errno)));
    end_rest(&j);
    interrupt_react(INTERRUPT_NOTED);
    if (j.err_pipe >= 0)
        close(j.err_pipe);
    if (j.asked >= 0)
        close(j.asked);
    return ok && explain(&j, status, err);
}
