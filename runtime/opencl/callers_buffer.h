// SPDX-License-Identifier: MIT
// Buffers and events of the caller's: what they must be, and how they are held.
#ifndef RUNTIME_CALLERS_BUFFER_H
#define RUNTIME_CALLERS_BUFFER_H

#include "runtime/opencl/device_pair.h"

typedef enum buffer_use { BUFFER_READ, BUFFER_WRITTEN } buffer_use;

// A public call's requirements of a buffer.
typedef struct buffer_need {
    const char *call;
    const char *argument;
    buffer_use use;
    size_t bytes;
} buffer_need;

// BAD_ARGUMENT where it is no buffer of one of the devices' contexts, or too small, or not to be
// used so by devices and the host. has[i]: whether device i has it. only: the device that must,
// or -1.
bool callers_buffer_check(cl_mem mem, const buffer_need *need, const device devices[2], int only,
                          bool has[2], duet_error *err);

// BAD_ARGUMENT where a list of events of the caller's is not one of this context.
bool callers_events_check(cl_uint n, const cl_event *events, cl_context context, const char *call,
                          duet_error *err);

// Events that a call waits for before it touches the caller's buffers. It waits on the host,
// because PoCL 3.1 aborts, or hangs, if a command waits for an event that has failed.
typedef struct callers_events {
    cl_event *list;
    cl_uint n;
} callers_events;

// Holds events of the caller's.
bool callers_events_hold(callers_events *to, cl_uint n, const cl_event *events, duet_error *err);

// Adds a marker behind what the caller has enqueued in the device's queue, and sends it on its way:
// none where the device has no queue of the caller's, or that is out of order and there are events
// already.
bool callers_events_mark(callers_events *to, const device *d, duet_error *err);

// Waits, and lets go of what is over. `what` waits for them, in the line that says they failed.
bool callers_events_wait(callers_events *events, const char *what, duet_error *err);
void callers_events_release(callers_events *events);

// Counted, like what is made, until mem_release (runtime/opencl/buffer.h).
cl_mem callers_buffer_hold(cl_mem mem);

#endif
