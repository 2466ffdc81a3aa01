// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "base/clock.h"

#include <time.h>

static int64_t read_ns(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

uint64_t clock_steady_ns(void)
{
    return (uint64_t)read_ns(CLOCK_MONOTONIC);
}

double clock_ms_since(uint64_t begun_ns)
{
    return (double)(clock_steady_ns() - begun_ns) * 1e-6;
}

int64_t clock_calendar_ns(void)
{
    return read_ns(CLOCK_REALTIME);
}

uint64_t clock_process_ns(void)
{
    return (uint64_t)read_ns(CLOCK_PROCESS_CPUTIME_ID);
}

uint64_t clock_thread_ns(void)
{
    return (uint64_t)read_ns(CLOCK_THREAD_CPUTIME_ID);
}

void clock_sleep_ns(uint64_t ns)
{
    struct timespec t = {.tv_sec = (time_t)(ns / 1000000000), .tv_nsec = (long)(ns % 1000000000)};
    nanosleep(&t, NULL);
}
