// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/interrupt.h"

#include "base/clock.h"
#include "base/error.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

// timeout(1) sends its signal twice within microseconds, and two threads may
// then be in the handler at once; a person is slower.
enum { LEAST_NS_APART = 200000000 };

static _Atomic uint64_t asked_ns; // 0: not asked

static void note(int number)
{
    uint64_t now = clock_steady_ns();
    uint64_t first = 0;
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

uint64_t interrupt_age_ns(void)
{
    uint64_t asked = atomic_load(&asked_ns);
    uint64_t now = clock_steady_ns();
    return asked != 0 && now > asked ? now - asked : 0;
}

void interrupt_forget(void)
{
    atomic_store(&asked_ns, 0);
}

bool interrupt_check(duet_error *err)
{
    return !interrupt_asked() || error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
}
