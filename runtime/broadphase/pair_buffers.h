// SPDX-License-Identifier: MIT
// Pairs that a step leaves on a device instead of bringing them to the host.
#ifndef RUNTIME_PAIR_BUFFERS_H
#define RUNTIME_PAIR_BUFFERS_H

#include "runtime/broadphase/part.h"
#include "runtime/duet_opencl.h"

typedef struct pair_buffers {
    const device *device; // NULL: pairs come to the host
    cl_mem pairs, count;  // the caller's, held; NULL: own
    uint64_t capacity;    // of the caller's
    buffer own_pairs, own_count;
    duet_pair_buffers last; // of the last step; its mems may be a part's
} pair_buffers;

// Whether a device can hand its pairs over without the host, and gains by it.
bool pair_buffers_can_copy(const pair_buffers *b, const device *from);

// Gathers the parts' spans: kept[i] says that the i-th is on its device. TOO_MANY where the
// caller's buffer has no space for them.
bool pair_buffers_fill(pair_buffers *b, part *const parts[2], const bool kept[2], duet_error *err);

// After a step that failed: no pairs, so that kernels which read the number do nothing. False where
// that cannot be written either.
bool pair_buffers_clear(pair_buffers *b);

void pair_buffers_drop(pair_buffers *b);

#endif
