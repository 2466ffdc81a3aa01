// SPDX-License-Identifier: MIT
// A step in two halves: a thread of its owner's carries it while the caller works.
#ifndef RUNTIME_BACKGROUND_H
#define RUNTIME_BACKGROUND_H

#include "runtime/opencl/thread_pool.h"

// All zero before the first step.
typedef struct background {
    thread_pool *thread;
    bool under_way; // the caller's alone to read
    bool ok;        // result of the step, from its thread
    duet_error err;
} background;

// The thread, where there is none yet.
bool background_open(background *b, duet_error *err);
void background_close(background *b);

// Starts step(owner), which fills ok and err.
void background_start(background *b, void (*step)(void *), void *owner);

// Waits for it; whether it went well.
bool background_end(background *b, duet_error *err);

#endif
