// SPDX-License-Identifier: MIT
// A library that ranks under test load first: what Open MPI yields while it waits is a nap, so that
// ranks that wait leave the few processors of a test machine to those at work.
#define _POSIX_C_SOURCE 200809L // nanosleep
#include <sched.h>
#include <time.h>

enum { NAP_NS = 100000 };

int sched_yield(void)
{
    return nanosleep(&(struct timespec){.tv_nsec = NAP_NS}, NULL);
}
