// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "tuner/cli/interrupt.h"

#include "runtime/base/clock.h"
#include "runtime/base/error.h"

#include <signal.h>
#include <stddef.h>

// timeout(1) sends its signal twice within microseconds; a person does not.
enum { LEAST_NS_APART = 200000000 };

static volatile sig_atomic_t asked;
static volatile uint64_t asked_ns; // written and read by the handler alone

static void note(int number)
{
    uint64_t now = clock_steady_ns();
    if (!asked) {
        asked = 1;
        asked_ns = now;
    } else if (now - asked_ns > LEAST_NS_APART) {
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
    return asked != 0;
}

void interrupt_forget(void)
{
    asked = 0;
}

bool interrupt_check(duet_error *err)
{
    return !asked || error_set(err, DUET_INTERRUPTED, "stopped");
}
