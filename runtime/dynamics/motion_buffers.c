// SPDX-License-Identifier: MIT
// Parts of a motion's state in buffers of the caller's.
#include "base/error.h"
#include "runtime/duet_opencl.h"
#include "runtime/dynamics/motion_map.h"
#include "runtime/opencl/callers_buffer.h"

static bool check_events(cl_mem rows, cl_uint n, const cl_event *events, const char *call,
                         duet_error *err)
{
    cl_context context = NULL;
    clGetMemObjectInfo(rows, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    return callers_events_check(n, events, context, call, err);
}

// The motion's queue runs in order, so that later steps follow the copy.
static bool copy(duet_motion *m, const buffer *from, cl_mem to, size_t bytes, cl_event *done,
                 duet_error *err)
{
    const device *d = m->device;
    cl_int code = bytes == 0
                      ? clEnqueueMarkerWithWaitList(d->queue, 0, NULL, done)
                      : clEnqueueCopyBuffer(d->queue, from->mem, to, 0, 0, bytes, 0, NULL, done);
    if (code == CL_SUCCESS)
        code = done ? clFlush(d->queue) : clFinish(d->queue);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: copying %zu bytes of states", d->info.selector, bytes);
}

bool duet_motion_copy_states(duet_motion *m, duet_state_part part, cl_mem rows, cl_uint n_events,
                             const cl_event *events, cl_event *done, duet_error *err)
{
    motion_buffer which;
    bool has[2];
    callers_events ready = {0};
    if (done)
        *done = NULL;
    if (!motion_is_whole(m, __func__, err) || !motion_part_buffer(m, part, &which, __func__, err))
        return false;
    const size_t bytes = (size_t)m->n * motion_words(m, which) * sizeof(cl_uint);
    const buffer_need need = {__func__, "rows", BUFFER_WRITTEN, bytes};
    bool ok = callers_buffer_check(rows, &need, m->def.pair->devices, 1, has, err) &&
              check_events(rows, n_events, events, __func__, err) &&
              callers_events_hold(&ready, n_events, events, err) &&
              callers_events_wait(&ready, "the states", err) && timeline_finish(&m->times, err) &&
              copy(m, &m->buffers[which], rows, bytes, done, err);
    callers_events_release(&ready);
    return ok;
}
