// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/interrupt.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/output.h"
#include "cli/say.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>
#include <unistd.h>

// timeout(1) sends its signal twice within microseconds, and two threads may
// then be in the handler at once; a person is slower.
enum { LEAST_NS_APART = 200000000 };

static _Atomic uint64_t asked_ns;  // 0: not asked
static _Atomic int asked_by;       // the signal
static _Atomic bool insisted;      // a second time
static _Atomic int told_file = -1; // is told of it
static _Atomic interrupt_reaction reaction;
static _Atomic bool told;         // that the program was stopped
static _Atomic bool told_waiting; // that the command must be waited for
static sigset_t heard;            // by the guard
static int also_heard;            // 0: no other signal

static void tell_asked(void)
{
    const int file = atomic_load(&told_file), code = errno;
    if (file >= 0 && write(file, "", 1) < 0)
        errno = code;
}

static void note(int number)
{
    uint64_t now = clock_steady_ns();
    uint64_t first = 0;
    if (atomic_compare_exchange_strong(&asked_ns, &first, now)) {
        atomic_store(&asked_by, number);
        tell_asked();
    } else if (now > first && now - first > LEAST_NS_APART) {
        atomic_store(&insisted, true);
    }
}

void interrupt_tell(int file)
{
    atomic_store(&told_file, file);
}

bool interrupt_asked(void)
{
    return atomic_load(&asked_ns) != 0;
}

// How long ago that was; 0: not asked.
static uint64_t interrupt_age_ns(void)
{
    uint64_t asked = atomic_load(&asked_ns);
    uint64_t now = clock_steady_ns();
    return asked != 0 && now > asked ? now - asked : 0;
}

void interrupt_forget(void)
{
    atomic_store(&asked_ns, 0);
    atomic_store(&insisted, false);
    atomic_store(&told_waiting, false);
}

bool interrupt_check(duet_error *err)
{
    return !interrupt_asked() || error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
}

void interrupt_pass(bool passes)
{
    pthread_sigmask(passes ? SIG_UNBLOCK : SIG_BLOCK, &heard, NULL);
}

void interrupt_told(void)
{
    atomic_store(&told, true);
}

void interrupt_react(interrupt_reaction to)
{
    if (to == INTERRUPT_ENDS_SILENTLY)
        interrupt_told();
    atomic_store(&reaction, to);
}

void interrupt_hear(int number)
{
    also_heard = number;
}

// ---------------------------------------------------------------- the end

static _Noreturn void end_by(int number)
{
    sigset_t only;
    output_remove_parts();
    signal(number, SIG_DFL);
    sigemptyset(&only);
    sigaddset(&only, number);
    pthread_sigmask(SIG_UNBLOCK, &only, NULL);
    raise(number);
    _exit(EXIT_INTERRUPTED);
}

void interrupt_end(void)
{
    end_by(atomic_load(&asked_by) ? atomic_load(&asked_by) : SIGINT);
}

// A broken pipe elsewhere is a write that fails.
static void on_pipe(int number)
{
    int code = errno;
    struct pollfd out = {.fd = STDOUT_FILENO, .events = POLLOUT};
    if (poll(&out, 1, 0) == 1 && (out.revents & POLLERR))
        end_by(number);
    errno = code;
}

// Neither stdio nor exit: another thread may hold their locks.
static void say(const char *line, size_t n)
{
    static const char clear[] = "\r\033[K";
    if (isatty(STDERR_FILENO) && write(STDERR_FILENO, clear, sizeof clear - 1) < 0)
        return;
    while (n > 0) {
        ssize_t written = write(STDERR_FILENO, line, n);
        if (written <= 0)
            return;
        line += written;
        n -= (size_t)written;
    }
}

#define SAY(line) say(line, sizeof(line) - 1)

// By that signal; 0: by the one that asked.
static _Noreturn void end_with_line(int number)
{
    if (!atomic_load(&told))
        SAY("duet: stopped\n");
    if (number > 0)
        end_by(number);
    interrupt_end();
}

// ---------------------------------------------------------------- the guard

#define LATE_NS 2000000000u
#define DEAF_NS 1500000000u
#define WAITS_NS 300000000u

// So seldom that it disturbs no measurement.
#define PAUSE_NS 200000000

static budget_watch watch = {.stopped = interrupt_asked};

static void look(void)
{
    uint64_t deadline = atomic_load(&watch.deadline_ns);
    uint64_t now = clock_steady_ns();
    if (deadline != 0 && now > deadline && now - deadline > LATE_NS) {
        SAY("duet: a script ran on for 2 s after its limit, and was ended\n");
        output_remove_parts();
        _exit(EXIT_FAILED);
    }
    interrupt_reaction to = atomic_load(&reaction);
    bool is_interactive = to == INTERRUPT_INTERACTIVE;
    bool is_awaited = is_interactive || to == INTERRUPT_AWAITED;
    if (is_interactive && interrupt_age_ns() > WAITS_NS && !atomic_exchange(&told_waiting, true))
        SAY("duet: stops once the call under way returns; Ctrl-C again ends the program\n");
    if (atomic_load(&insisted) || (!is_awaited && interrupt_age_ns() > DEAF_NS))
        end_with_line(0);
}

static void *guard(void *unused)
{
    const struct timespec pause = {.tv_nsec = PAUSE_NS};
    for (;;) {
        int number = sigtimedwait(&heard, NULL, &pause);
        if (number > 0 && atomic_load(&reaction) >= INTERRUPT_ENDS) {
            tell_asked();
            end_with_line(number);
        }
        if (number > 0)
            note(number);
        look();
    }
    return unused;
}

// The guard alone hears signals: LLVM inside PoCL listens too, and would spoil what it
// compiles and complain of that.
static void begin_guard(void)
{
    pthread_t thread;
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool begun = pthread_create(&thread, NULL, guard, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!begun)
        return;
    pthread_detach(thread);
    interrupt_pass(false);
}

// SIGHUP stays ignored under nohup(1).
void interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = note, .sa_flags = SA_RESTART};
    struct sigaction before;
    sigemptyset(&action.sa_mask);
    sigemptyset(&heard);
    const int numbers[] = {SIGINT, SIGTERM, SIGHUP, also_heard};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        if (numbers[i] == 0)
            continue;
        if (numbers[i] == SIGHUP &&
            (sigaction(SIGHUP, NULL, &before) != 0 || before.sa_handler == SIG_IGN))
            continue;
        sigaction(numbers[i], &action, NULL);
        sigaddset(&heard, numbers[i]);
    }
    action.sa_handler = on_pipe;
    sigaction(SIGPIPE, &action, NULL);
    budget_set_watch(&watch);
    begin_guard();
}
