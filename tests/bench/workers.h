// SPDX-License-Identifier: MIT
// A few threads that do one stage after another together.
#ifndef BENCH_WORKERS_H
#define BENCH_WORKERS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct workers workers;

// One thread's part of a stage; worker counts from 0, the caller's thread.
typedef void stage_part(void *context, uint32_t worker);

workers *workers_open(uint32_t n); // NULL where threads or memory run out
void workers_close(workers *w);

// Runs the part once on each thread and waits for all of them.
void workers_run(workers *w, stage_part *part, void *context);

// CPU time that all threads have used since workers_open, waiting left out.
uint64_t workers_cpu_ns(const workers *w);

#endif
