// SPDX-License-Identifier: MIT
// Devices that go away: calls to OpenCL that fail from some call on, or once.
//
// A program that has lost.c in it calls the loader through it. Each call that can fail
// is counted; a call that waits does wait before it fails, for nothing touches memory
// once a driver has told that its device is gone. An object that is released, or unmapped, is so.
#ifndef TESTS_LOST_H
#define TESTS_LOST_H

#include "runtime/opencl/device_pair.h"

#include <stdint.h>

typedef enum lost_way {
    LOST_FOR_EVER, // from the call on
    LOST_ONCE,     // only that call
    LOST_A,        // from the call on, calls of A
    LOST_B,
    LOST_WAYS
} lost_way;

const char *lost_way_name(lost_way way);

// Says whose calls are A's and B's.
void lost_know(const duet_device_pair *pair);

// Counts from 0 again, and fails call k; UINT32_MAX: none.
void lost_begin(lost_way way, uint32_t k);

// Lets all calls pass again. Returns how many were counted.
uint32_t lost_end(void);

// How often a queue was waited for to its end since lost_begin.
uint32_t lost_finishes(void);

// Unmaps since lost_begin of what was not mapped there: a driver refuses them, and what was
// mapped stays so.
uint32_t lost_wrong_unmaps(void);

// The first call that failed since lost_begin, or "none".
const char *lost_call(void);

#endif
