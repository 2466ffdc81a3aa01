// SPDX-License-Identifier: MIT
// Duet inside a program that uses OpenCL itself: device pairs on the caller's queues, objects
// from the caller's buffers, pairs and states left in buffers, and events.
//
// duet.h does not include this header, because it needs <CL/cl.h> of OpenCL 1.2 or later.
//
// Duet retains the contexts, devices, queues, buffers and events that a call takes as long as
// it needs them, and releases no other reference: the caller may release its own at once.
// Kernels run in queues of Duet's own in the caller's contexts. Duet puts nothing into a queue of
// the caller but a marker, if a call says so, and never calls clFinish on one.
//
// A buffer is a cl_mem of the pair's context with at least the bytes that the call needs. Give a
// part of a buffer as a sub-buffer. BAD_ARGUMENT names the argument that is of another context,
// too small, or not readable or writable.
//
// Threads: as in duet.h, a world or a motion belongs to one thread at a time. The caller may use
// its own queues from any thread meanwhile.
#ifndef DUET_OPENCL_H
#define DUET_OPENCL_H

#include "duet_motion_map.h"
#include "duet_task.h"
#include "duet_world.h"

#include <CL/cl.h>

DUET_C_BEGIN

// ---------------------------------------------------------------- device pairs

// Creates a device pair on the devices and contexts of two queues, of one platform or of two.
// If a queue is NULL, def->a or def->b selects its device, in a context of Duet's; if that is
// NULL too, the pair is the other queue's device alone. With both queues def->a and def->b
// are not read.
//
// Plans and profiles are those of the same devices opened by their selectors. A part that the
// caller cut off a device is "pocl:0[2 units]", because OpenCL does not say which units it has.
DUET_API duet_device_pair *duet_device_pair_create_on_queues(const duet_device_pair_def *def,
                                                             cl_command_queue a, cl_command_queue b,
                                                             duet_error *err);

// ---------------------------------------------------------------- objects

// Sets n objects in a buffer, which the next step reads: rows of a kind that duet_world_map_objects
// takes, laid out as in C. A device of the buffer's context reads them in place; the other device
// gets them through the host, once for each call.
//
// The step reads them after `events` [n_events], and after all that the caller enqueued before in
// the pair's queues of that context (an out-of-order queue: only if n_events is 0), for which it
// puts a marker into them. The step waits for that on the host. Do not change them from then until
// the step is over; for later steps set them again if they changed. SIZES are copied at once, and
// the call waits for that.
//
// The step checks objects as it does those of the host.
DUET_API bool duet_world_set_objects_buffer(duet_world *world, duet_object_kind kind,
                                            cl_mem objects, uint32_t n, cl_uint n_events,
                                            const cl_event *events, duet_error *err);

// ---------------------------------------------------------------- pairs

// The buffers that hold a step's pairs.
typedef struct duet_pair_buffers {
    cl_mem pairs; // duet_pair [n], A's first
    cl_mem count; // one cl_ulong, n
    uint64_t n;
} duet_pair_buffers;

// Leaves the pairs of the following steps in `pairs` and their number in `count`, buffers of the
// context of a device (0: A, 1: B). If one is NULL, Duet makes it; it is valid until the world's
// next step. The pairs do not come to the host: a result's spans count them without having any,
// and its hash is 0.
//
// If `pairs` is too small, the step fails with TOO_MANY and a line that says how many bytes it
// needs, and the result is filled in. After any failure `pairs` is as before, and `count` is 0.
DUET_API bool duet_world_leave_pairs(duet_world *world, int device, cl_mem pairs, cl_mem count,
                                     duet_error *err);

// Brings the pairs of the following steps to the host again, as by default.
DUET_API bool duet_world_bring_pairs(duet_world *world, duet_error *err);

// Gets the buffers of the last step. They are not retained for the caller.
DUET_API bool duet_world_get_pair_buffers(duet_world *world, duet_pair_buffers *buffers,
                                          duet_error *err);

// Begins a step as duet_world_step_begin does, with an event, which the caller releases. It
// completes once the pairs and their number are in their buffers; a step that fails leaves the
// number 0. Commands that wait for it can be enqueued at once, in the context of the buffers. Call
// duet_world_step_end all the same. The event fails, with a status below 0, only if a device is
// lost.
DUET_API bool duet_world_step_begin_event(duet_world *world, cl_event *done, duet_error *err);

// ---------------------------------------------------------------- states

// Copies rows of a part of the state of all objects, as duet_motion_map_states has them, to a
// buffer of B's context. The call waits for `events` [n_events], but not for the copy: *done, which
// the caller releases, completes with it. done NULL: the call waits for the copy too.
DUET_API bool duet_motion_copy_states(duet_motion *motion, duet_state_part part, cl_mem rows,
                                      cl_uint n_events, const cl_event *events, cl_event *done,
                                      duet_error *err);

// ---------------------------------------------------------------- tasks

// Lets an array of a task lie in a buffer with its elements, instead of memory of Duet's, until
// duet_task_set_array or another call. A device of the buffer's context works on the buffer in
// place; the other device gets its part through the host in each run, and what it wrote comes back
// into the buffer. If both devices are of that context, only B writes in place, and a "sum" is
// added on the host. The kernel's results are in the buffer when duet_task_run returns.
//
// A run reads the buffer after `events` [n_events], and after all that the caller enqueued before
// this call in the pair's queues of that context, as duet_world_set_objects_buffer does. To use
// the buffer for the next run, too, once its contents changed, make this call again.
DUET_API bool duet_task_set_buffer(duet_task *task, const char *name, cl_mem elements,
                                   cl_uint n_events, const cl_event *events, duet_error *err);

DUET_C_END

#endif
