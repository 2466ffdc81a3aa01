// SPDX-License-Identifier: MIT
#include "runtime/opencl/callers_buffer.h"

#include "base/error.h"
#include "base/list.h"

#include <stdlib.h>

static bool check_context(cl_context context, const buffer_need *need, const device devices[2],
                          int only, bool has[2], duet_error *err)
{
    bool any = false;
    for (int i = 0; i < 2; ++i) {
        has[i] = devices[i].context == context;
        any |= has[i] && (only < 0 || only == i);
    }
    return any ||
           bad_argument(err, "%s: %s is of another context; expected that of %s%s%s", need->call,
                        need->argument, devices[only < 0 ? 0 : only].info.selector,
                        only < 0 ? " or " : "", only < 0 ? devices[1].info.selector : "");
}

static bool check_flags(cl_mem_flags flags, const buffer_need *need, duet_error *err)
{
    bool reads = need->use == BUFFER_READ;
    cl_mem_flags never = reads ? CL_MEM_WRITE_ONLY | CL_MEM_HOST_WRITE_ONLY
                               : CL_MEM_READ_ONLY | CL_MEM_HOST_READ_ONLY;
    return !(flags & (never | CL_MEM_HOST_NO_ACCESS)) ||
           bad_argument(
               err,
               "%s: %s cannot be %s by %s; expected a buffer that both devices and the host can %s",
               need->call, need->argument, reads ? "read" : "written",
               flags & (CL_MEM_WRITE_ONLY | CL_MEM_READ_ONLY) & never ? "devices" : "the host",
               reads ? "read" : "write");
}

bool callers_buffer_check(cl_mem mem, const buffer_need *need, const device devices[2], int only,
                          bool has[2], duet_error *err)
{
    cl_mem_object_type type = 0;
    cl_context context = NULL;
    cl_mem_flags flags = 0;
    size_t bytes = 0;
    if (!error_given(mem, need->call, need->argument, err))
        return false;
    cl_int code = clGetMemObjectInfo(mem, CL_MEM_TYPE, sizeof type, &type, NULL);
    if (code == CL_SUCCESS)
        code = clGetMemObjectInfo(mem, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    if (code == CL_SUCCESS)
        code = clGetMemObjectInfo(mem, CL_MEM_FLAGS, sizeof flags, &flags, NULL);
    if (code == CL_SUCCESS)
        code = clGetMemObjectInfo(mem, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    if (code != CL_SUCCESS || type != CL_MEM_OBJECT_BUFFER)
        return bad_argument(err, "%s: %s is no buffer", need->call, need->argument);
    if (bytes < need->bytes)
        return bad_argument(err, "%s: %s has %zu bytes; expected at least %zu", need->call,
                            need->argument, bytes, need->bytes);
    return check_context(context, need, devices, only, has, err) && check_flags(flags, need, err);
}

bool callers_events_check(cl_uint n, const cl_event *events, cl_context context, const char *call,
                          duet_error *err)
{
    if (n > 0 && !error_given(events, call, "events", err))
        return false;
    for (cl_uint i = 0; i < n; ++i) {
        cl_context of = NULL;
        cl_int code = events[i] ? clGetEventInfo(events[i], CL_EVENT_CONTEXT, sizeof of, &of, NULL)
                                : CL_INVALID_EVENT;
        if (code != CL_SUCCESS || of != context)
            return bad_argument(err,
                                "%s: event %u of %u is %s; expected one of the buffer's context",
                                call, i, n, code != CL_SUCCESS ? "none" : "of another context");
    }
    return true;
}

// Space for one more.
static bool grow(callers_events *to, duet_error *err)
{
    cl_event *list = list_room(to->list, to->n, sizeof(cl_event), err);
    to->list = list ? list : to->list;
    return list;
}

bool callers_events_hold(callers_events *to, cl_uint n, const cl_event *events, duet_error *err)
{
    for (cl_uint i = 0; i < n; ++i) {
        if (!grow(to, err))
            return false;
        clRetainEvent(events[i]);
        device_object_made();
        to->list[to->n++] = events[i];
    }
    return true;
}

bool callers_events_mark(callers_events *to, const device *d, duet_error *err)
{
    cl_command_queue_properties properties = 0;
    if (!d->callers) // Duet opened the device
        return true;
    clGetCommandQueueInfo(d->callers, CL_QUEUE_PROPERTIES, sizeof properties, &properties, NULL);
    if (to->n > 0 && (properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE))
        return true;
    if (!grow(to, err))
        return false;
    cl_int code = clEnqueueMarkerWithWaitList(d->callers, 0, NULL, &to->list[to->n]);
    if (code == CL_SUCCESS) {
        device_object_made();
        ++to->n;
        code = clFlush(d->callers);
    }
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: a marker in the caller's queue", d->info.selector);
}

bool callers_events_wait(callers_events *events, const char *what, duet_error *err)
{
    cl_int code = events->n > 0 ? clWaitForEvents(events->n, events->list) : CL_SUCCESS;
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "an event that %s wait for has failed", what);
    callers_events_release(events);
    return true;
}

void callers_events_release(callers_events *events)
{
    for (cl_uint i = 0; i < events->n; ++i) {
        clReleaseEvent(events->list[i]);
        device_object_gone();
    }
    free(events->list);
    *events = (callers_events){0};
}

cl_mem callers_buffer_hold(cl_mem mem)
{
    if (mem) {
        clRetainMemObject(mem);
        device_object_made();
    }
    return mem;
}
