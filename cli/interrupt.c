// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/interrupt.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "cli/say.h"

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

static _Atomic uint64_t asked_ns; // 0: not asked
static _Atomic int asked_by;      // the signal
static _Atomic bool insisting;

static void note(int number)
{
    uint64_t now = clock_steady_ns();
    uint64_t first = 0;
    atomic_store(&asked_by, number);
    if (atomic_compare_exchange_strong(&asked_ns, &first, now))
        return;
    if (now > first && now - first > LEAST_NS_APART) {
        signal(number, SIG_DFL);
        raise(number);
    }
}

void interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = note, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
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
}

void interrupt_insist(void)
{
    atomic_store(&insisting, true);
}

void interrupt_die(void)
{
    int number = atomic_load(&asked_by);
    if (!interrupt_asked())
        return;
    signal(number, SIG_DFL);
    kill(getpid(), number); // the thread that calls may block it, not the others
}

bool interrupt_check(duet_error *err)
{
    return !interrupt_asked() || error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
}

// ---------------------------------------------------------------- the watchdog

#define LATE_NS 2000000000u
#define DEAF_NS 1500000000u

// So seldom that it disturbs no measurement.
#define PAUSE_NS 200000000

static budget_watch watch = {.stopped = interrupt_asked};

// Neither stdio nor exit: the program's thread may hold their locks.
static void tell(const char *line, size_t n)
{
    while (n > 0) {
        ssize_t written = write(STDERR_FILENO, line, n);
        if (written <= 0)
            break;
        line += written;
        n -= (size_t)written;
    }
}

#define TELL(line) tell(line, sizeof(line) - 1)

static void look(void)
{
    uint64_t deadline = atomic_load(&watch.deadline_ns);
    uint64_t now = clock_steady_ns();
    if (deadline == 0 && !atomic_load(&insisting))
        return;
    if (deadline != 0 && now > deadline && now - deadline > LATE_NS) {
        TELL("duet: a script ran on for 2 s after its limit, and was ended\n");
        _exit(EXIT_FAILED);
    }
    if (interrupt_age_ns() > DEAF_NS) {
        TELL("duet: stopped\n");
        interrupt_die();
    }
}

static void *guard(void *unused)
{
    const struct timespec pause = {.tv_nsec = PAUSE_NS};
    for (;;) {
        nanosleep(&pause, NULL);
        look();
    }
    return unused;
}

// Signals are for the other threads: what they wait for is to end.
void interrupt_guard_scripts(void)
{
    pthread_t thread;
    sigset_t all;
    sigset_t before;
    budget_set_watch(&watch);
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    if (pthread_create(&thread, NULL, guard, NULL) == 0)
        pthread_detach(thread);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}
