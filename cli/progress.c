// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/progress.h"

#include "base/clock.h"

#include <stdio.h>
#include <unistd.h>

enum { LEAST_NS_BETWEEN = 100000000 };

progress progress_begin(const char *what, uint64_t total)
{
    return (progress){
        .what = what,
        .total = total,
        .begun_ns = clock_steady_ns(),
        .on_terminal = isatty(STDERR_FILENO),
    };
}

void progress_show(progress *p, uint64_t done)
{
    uint64_t now = clock_steady_ns();
    if (!p->on_terminal || now - p->shown_ns < LEAST_NS_BETWEEN)
        return;
    p->shown_ns = now;
    double seconds = (double)(now - p->begun_ns) * 1e-9;
    double rate = seconds > 0 ? (double)done / seconds : 0;
    fprintf(stderr, "\r\033[K%s %llu", p->what, (unsigned long long)done);
    if (p->total > 0)
        fprintf(stderr, " of %llu", (unsigned long long)p->total);
    if (done > 0)
        fprintf(stderr, ", %.3g a second", rate);
    if (done > 0 && p->total > done)
        fprintf(stderr, ", %.0f s left", (double)(p->total - done) / rate);
    fflush(stderr);
}

void progress_end(progress *p)
{
    if (p->on_terminal && p->shown_ns > 0)
        fputs("\r\033[K", stderr);
}
