// SPDX-License-Identifier: MIT
// Duet inside a program that uses OpenCL itself: device pairs on the caller's queues, objects
// from the caller's buffers, pairs and states left in buffers, and events.
//
// duet.h leaves this header out, for it needs <CL/cl.h> of OpenCL 1.2 or later.
//
// Contexts, devices, queues, buffers and events that a call is given are retained as long as
// Duet needs them and never released otherwise: the caller may release its own at once.
// Kernels run in queues of Duet's own in the caller's contexts. In a queue of the caller's Duet
// puts nothing but a marker, where a call says so, and never ends one by clFinish.
//
// A buffer is a cl_mem of the pair's context with at least so many bytes. The part of one is
// given as a sub-buffer. BAD_ARGUMENT names the argument that is of another context, too small,
// or not to be read or written.
//
// Threads: as in duet.h, a world or a motion belongs to one thread at a time. While it does the
// caller may use its own queues from any thread.
#ifndef DUET_OPENCL_H
#define DUET_OPENCL_H

#include "duet_motion_map.h"
#include "duet_world.h"

#include <CL/cl.h>

DUET_C_BEGIN

// ---------------------------------------------------------------- device pairs

// A device pair whose devices and contexts are those of two queues, of one platform or of two.
// For a queue that is NULL its device is opened as def->a or def->b says, in a context of
// Duet's; where that is NULL too, both are the other's device, and the pair is one of one.
// Where both queues are given def->a and def->b are not read.
//
// Plans and profiles are those of the same devices opened by their selectors. A part that the
// caller cut off a device is "pocl:0[2 units]": which units it has OpenCL does not tell.
DUET_API duet_device_pair *duet_device_pair_create_on_queues(const duet_device_pair_def *def,
                                                             cl_command_queue a, cl_command_queue b,
                                                             duet_error *err);

// ---------------------------------------------------------------- objects

// The next step reads n objects from a buffer: rows of a kind that duet_world_map_objects takes,
// as C has them. A device of the buffer's context reads them there, without a copy; the other one
// gets them through the host, once for each call.
//
// They are read once `events` [n_events] are over, and all that the caller enqueued before in the
// pair's queues of that context (out of order: where n_events is 0), for which a marker is put
// into them. The step waits for that on the host. From then until the step is over they are not to
// be changed; for later steps they are set again where they changed. SIZES are copied at once, and
// the call waits for that.
//
// The step checks objects as it does those of the host.
DUET_API bool duet_world_set_objects_buffer(duet_world *world, duet_object_kind kind,
                                            cl_mem objects, uint32_t n, cl_uint n_events,
                                            const cl_event *events, duet_error *err);

// ---------------------------------------------------------------- pairs

// Where a step leaves its pairs.
typedef struct duet_pair_buffers {
    cl_mem pairs; // duet_pair [n], A's first
    cl_mem count; // one cl_ulong, n
    uint64_t n;
} duet_pair_buffers;

// From the next step on pairs are left in `pairs`, and how many in `count`, buffers of the
// context of a device (0: A, 1: B). For a buffer that is NULL Duet makes one, which is valid until
// the world's next step. They do not come to the host: a result's spans count them without
// having any, and its hash is 0.
//
// Where `pairs` is too small the step fails with TOO_MANY and a line that says how many bytes it
// must have, and the result is filled in. After any failure `pairs` is as before, and `count` is 0.
DUET_API bool duet_world_leave_pairs(duet_world *world, int device, cl_mem pairs, cl_mem count,
                                     duet_error *err);

// From the next step on pairs come to the host, as at first.
DUET_API bool duet_world_bring_pairs(duet_world *world, duet_error *err);

// Those of the last step. They are not retained for the caller.
DUET_API bool duet_world_get_pair_buffers(duet_world *world, duet_pair_buffers *buffers,
                                          duet_error *err);

// duet_world_step_begin with an event, which the caller releases: it is over once the pairs and
// their number are in their buffers, and a step that fails leaves the number 0. Commands that wait
// for it can be enqueued at once, in the context of the buffers. duet_world_step_end is called all
// the same. Only where a device is lost does the event fail, with a status below 0.
DUET_API bool duet_world_step_begin_event(duet_world *world, cl_event *done, duet_error *err);

// ---------------------------------------------------------------- states

// Copies rows of a part of the state of all objects, as duet_motion_map_states has them, to a
// buffer of B's context. The call waits for `events` [n_events], but not for the copy: *done, which
// the caller releases, is over when that is. With done NULL it waits for both.
DUET_API bool duet_motion_copy_states(duet_motion *motion, duet_state_part part, cl_mem rows,
                                      cl_uint n_events, const cl_event *events, cl_event *done,
                                      duet_error *err);

DUET_C_END

#endif
