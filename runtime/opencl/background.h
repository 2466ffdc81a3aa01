// SPDX-License-Identifier: MIT
// A step in two halves: a thread of its owner's carries it while the caller works.
#ifndef RUNTIME_BACKGROUND_H
#define RUNTIME_BACKGROUND_H

#include "runtime/opencl/thread_pool.h"

// All zero before the first step.
typedef struct background {
    thread_pool *thread;
    bool (*step)(void *owner, duet_error *err);
    void *owner; // of the step that is under way, which the caller alone reads; NULL: none is
    bool ok;     // the step's result, from its thread
    duet_error err;
} background;

// The thread, where there is none yet.
bool background_open(background *b, duet_error *err);
void background_close(background *b);

void background_start(background *b, bool (*step)(void *owner, duet_error *err), void *owner);

// Waits for it; whether it went well.
bool background_end(background *b, duet_error *err);

#endif
