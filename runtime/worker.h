// SPDX-License-Identifier: MIT
// A thread that waits for one job at a time.
#ifndef RUNTIME_WORKER_H
#define RUNTIME_WORKER_H

#include "runtime/duet.h"

typedef struct worker worker;

worker *worker_open(duet_error *err);
void worker_close(worker *w); // waits for the job under way

// Starts job(arg) in the worker's thread; the last one must have been waited for.
void worker_start(worker *w, void (*job)(void *), void *arg);
void worker_wait(worker *w);

#endif
