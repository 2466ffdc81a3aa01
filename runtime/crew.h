// SPDX-License-Identifier: MIT
// Threads that wait for one job at a time, which each of them does.
#ifndef RUNTIME_CREW_H
#define RUNTIME_CREW_H

#include "runtime/duet.h"

typedef struct crew crew;

crew *crew_open(uint32_t n_threads, duet_error *err);
void crew_close(crew *c); // waits for the job under way

// Starts job(arg) in every thread; the last job must have been waited for.
void crew_start(crew *c, void (*job)(void *), void *arg);
void crew_wait(crew *c);

#endif
