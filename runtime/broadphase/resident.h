// SPDX-License-Identifier: MIT
// Objects that are in a device's memory before the step: where B made them, or in a buffer of
// the caller's. A device that has them reads them there; the host sees them where it must.
#ifndef RUNTIME_RESIDENT_H
#define RUNTIME_RESIDENT_H

#include "runtime/broadphase/part.h"
#include "runtime/opencl/callers_buffer.h"

typedef struct resident {
    buffer objects;       // empty: the objects are the host's
    bool on[2];           // the devices that have them
    bool callers;         // the buffer is held
    callers_events ready; // what must be over first; none once it is
    const void *seen;     // by the host; NULL: not yet
    void *mapped;         // that memory, where it is the device's own
} resident;

// Waits for what must be over first.
bool resident_await(resident *r, duet_error *err);

// Makes the first bytes visible to the host, in place or in the block; returns at once where they
// are. What is in place is so until resident_end_sight, for a step at most. The part of the
// device that has them takes the time.
bool resident_see(resident *r, size_t bytes, host_block *block, const device devices[2],
                  part parts[2], duet_error *err);
void resident_end_sight(resident *r, const device devices[2]);

// Lets go of the buffer.
void resident_drop(resident *r);

#endif
