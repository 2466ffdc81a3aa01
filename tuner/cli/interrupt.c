// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "tuner/cli/interrupt.h"

#include "runtime/base/error.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t asked;

static void note(int signal)
{
    (void)signal;
    asked = 1;
}

void interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = note, .sa_flags = SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool interrupt_asked(void)
{
    return asked != 0;
}

bool interrupt_check(duet_error *err)
{
    return !asked || error_set(err, DUET_INTERRUPTED, "stopped");
}
