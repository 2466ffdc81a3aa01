// SPDX-License-Identifier: MIT
// Processor time of each thread of the process, as the kernel counts it.
#ifndef BENCH_THREAD_TIMES_H
#define BENCH_THREAD_TIMES_H

#include <stdint.h>

enum { THREAD_TIMES_ROOM = 512 };

typedef struct thread_times {
    struct {
        int id;
        uint64_t ns;
    } threads[THREAD_TIMES_ROOM];
    uint32_t n; // 0: the system does not tell
} thread_times;

void thread_times_read(thread_times *t);

// The main thread's time since, and the busiest other thread's.
double thread_times_since_ms(const thread_times *before, const thread_times *now);

#endif
