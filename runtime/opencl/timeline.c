// SPDX-License-Identifier: MIT
#include "runtime/opencl/timeline.h"

#include "base/error.h"

#include <assert.h>
#include <sched.h>
#include <string.h>

void timeline_begin(timeline *t, const device *d, bool timed)
{
    if (t->n_events > 0)
        timeline_clear(t);
    t->lost = CL_SUCCESS;
    t->device = d;
    t->untimed = !timed;
    t->n_launches = t->n_waits = 0;
    if (!timed)
        return;
    t->n_stages = 0;
    t->first_begin = t->last_end = 0;
}

void timeline_begin_step(timeline *t, const device *d, uint64_t step)
{
    timeline_begin(t, d,
                   d->info.host_memory || t->n_stages == 0 || step % TIMELINE_TIMED_EVERY == 0);
}

static int stage_index(timeline *t, const char *name, bool transfer)
{
    for (int i = 0; i < t->n_stages; ++i)
        if (strcmp(t->stages[i].name, name) == 0)
            return i;
    assert(t->n_stages < TIMELINE_STAGES);
    t->stages[t->n_stages] = (duet_stage){.name = name, .transfer = transfer};
    return t->n_stages++;
}

static void release(cl_event event)
{
    clReleaseEvent(event);
    device_object_gone();
}

// Waits for the queue once the list is full, so that any number fits.
static bool keep_event(timeline *t, const char *stage, bool transfer, cl_event event,
                       duet_error *err)
{
    int at = t->untimed ? 0 : stage_index(t, stage, transfer);
    device_object_made();
    t->seen = false;
    if (t->n_events == TIMELINE_EVENTS && !timeline_finish(t, err)) {
        release(event);
        return false;
    }
    t->events[t->n_events].stage = at;
    t->events[t->n_events].event = event;
    ++t->n_events;
    return true;
}

// Keeps a launch or a fill; event is NULL in an untimed step.
static bool keep_command(timeline *t, const char *stage, cl_event event, duet_error *err)
{
    t->unheard = true;
    t->seen = false;
    return !event || keep_event(t, stage, false, event, err);
}

static bool set_args(const kernel *k, const void *values, const device *d, duet_error *err)
{
    const launcher *l = &k->launcher;
    for (uint32_t i = 0; i < l->n; ++i) {
        cl_int code =
            clSetKernelArg(k->cl, i, l->args[i].bytes, (const char *)values + l->args[i].at);
        if (code != CL_SUCCESS)
            return error_set_cl(err, code, "%s on %s: argument %u", k->name, d->info.selector, i);
    }
    return true;
}

bool timeline_launch(timeline *t, const char *stage, const kernel *k, uint64_t work,
                     const void *values, duet_error *err)
{
    return timeline_launch_after(t, stage, k, work, NULL, values, err);
}

bool timeline_launch_after(timeline *t, const char *stage, const kernel *k, uint64_t work,
                           cl_event after, const void *values, duet_error *err)
{
    if (work == 0)
        return true;
    if (!set_args(k, values, t->device, err))
        return false;
    uint64_t per_group = (uint64_t)k->group * k->per_item;
    size_t n_groups = (size_t)((work + per_group - 1) / per_group);
    const size_t group[3] = {k->group, 1, 1};
    const size_t along_first[3] = {n_groups * k->group, 1, 1};
    const size_t along_third[3] = {k->group, 1, n_groups};
    cl_event event = NULL;
    cl_int code = clEnqueueNDRangeKernel(
        t->device->queue, k->cl, 3, NULL, t->device->driver.third_axis ? along_third : along_first,
        group, after ? 1 : 0, after ? &after : NULL, t->untimed ? NULL : &event);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s on %s: launch", k->name, t->device->info.selector);
    ++t->n_launches;
    return keep_command(t, stage, event, err);
}

bool timeline_fill(timeline *t, const char *stage, buffer *b, uint32_t value, size_t from,
                   size_t to, duet_error *err)
{
    if (from == to)
        return true;
    cl_event event = NULL;
    cl_int code =
        clEnqueueFillBuffer(t->device->queue, b->mem, &value, sizeof value, from * sizeof value,
                            (to - from) * sizeof value, 0, NULL, t->untimed ? NULL : &event);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: filling a buffer", t->device->info.selector);
    return keep_command(t, stage, event, err);
}

// If kernels work in place, the host sees all once the queue is empty.
static bool await_queue(timeline *t, duet_error *err)
{
    cl_int code = clFinish(t->device->queue);
    t->unheard = code != CL_SUCCESS;
    t->seen = code == CL_SUCCESS;
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: running the step", t->device->info.selector);
}

// Hands wrapped host memory from one side to the other without moving it. A wait here costs a
// CPU's driver two wake-ups, a tenth of a millisecond.
static bool hand_over(timeline *t, buffer *b, cl_map_flags flags, size_t bytes, cl_bool wait,
                      duet_error *err)
{
    cl_int code = CL_SUCCESS;
    if (t->device->driver.in_place)
        return !wait || await_queue(t, err);
    t->seen = false;
    void *seen =
        clEnqueueMapBuffer(t->device->queue, b->mem, wait, flags, 0, bytes, 0, NULL, NULL, &code);
    if (seen)
        code = clEnqueueUnmapMemObject(t->device->queue, b->mem, seen, 0, NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: mapping %zu bytes", t->device->info.selector, bytes);
}

bool timeline_write(timeline *t, const char *stage, buffer *b, const void *from, size_t bytes,
                    duet_error *err)
{
    if (bytes == 0)
        return true;
    return b->host == from ? hand_over(t, b, CL_MAP_WRITE, bytes, CL_FALSE, err)
                           : timeline_write_at(t, stage, b, 0, from, bytes, err);
}

bool timeline_write_at(timeline *t, const char *stage, buffer *b, size_t at, const void *from,
                       size_t bytes, duet_error *err)
{
    if (bytes == 0)
        return true;
    cl_event event = NULL;
    cl_int code =
        clEnqueueWriteBuffer(t->device->queue, b->mem, CL_FALSE, at, bytes, from, 0, NULL, &event);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: sending %zu bytes", t->device->info.selector, bytes);
    return keep_event(t, stage, true, event, err);
}

// Keeps the event of a command on the queue beside, which begins at once.
static bool keep_beside(timeline *t, const char *stage, cl_event event, cl_int code,
                        const char *doing, size_t bytes, duet_error *err)
{
    if (code == CL_SUCCESS)
        code = clFlush(t->device->beside);
    t->beside = true;
    if (event && !keep_event(t, stage, true, event, err))
        return false;
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: %s %zu bytes", t->device->info.selector, doing, bytes);
}

bool timeline_write_beside(timeline *t, const char *stage, buffer *b, size_t at, const void *from,
                           size_t bytes, duet_error *err)
{
    cl_event event = NULL;
    cl_int code =
        clEnqueueWriteBuffer(t->device->beside, b->mem, CL_FALSE, at, bytes, from, 0, NULL, &event);
    return keep_beside(t, stage, event, code, "sending", bytes, err);
}

bool timeline_read_beside(timeline *t, const char *stage, buffer *b, void *to, size_t bytes,
                          cl_event after, duet_error *err)
{
    cl_event event = NULL;
    cl_int code = clEnqueueReadBuffer(t->device->beside, b->mem, CL_FALSE, 0, bytes, to,
                                      after ? 1 : 0, after ? &after : NULL, &event);
    return keep_beside(t, stage, event, code, "fetching", bytes, err);
}

bool timeline_follow(timeline *t, cl_event beside, duet_error *err)
{
    cl_int code = clEnqueueBarrierWithWaitList(t->device->queue, 1, &beside, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: waiting for what was sent", t->device->info.selector);
}

static bool enqueue_read(timeline *t, const char *stage, buffer *b, size_t at, void *to,
                         size_t bytes, cl_bool wait, duet_error *err)
{
    if (bytes == 0)
        return true;
    t->n_waits += wait;
    if (b->host == to)
        return hand_over(t, b, CL_MAP_READ, bytes, wait, err);
    cl_event event = NULL;
    cl_int code =
        clEnqueueReadBuffer(t->device->queue, b->mem, wait, at, bytes, to, 0, NULL, &event);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: fetching %zu bytes", t->device->info.selector, bytes);
    t->unheard = t->unheard && !wait;
    return keep_event(t, stage, true, event, err);
}

bool timeline_read(timeline *t, const char *stage, buffer *b, void *to, size_t bytes,
                   duet_error *err)
{
    return timeline_read_at(t, stage, b, 0, to, bytes, err);
}

bool timeline_read_at(timeline *t, const char *stage, buffer *b, size_t at, void *to, size_t bytes,
                      duet_error *err)
{
    return enqueue_read(t, stage, b, at, to, bytes, CL_TRUE, err);
}

bool timeline_start_read(timeline *t, const char *stage, buffer *b, size_t at, void *to,
                         size_t bytes, duet_error *err)
{
    return enqueue_read(t, stage, b, at, to, bytes, CL_FALSE, err) && timeline_flush(t, err);
}

// Nobody waits for the buffers to be handed back: what comes next in the queue does.
bool timeline_see(timeline *t, const char *stage, const buffer *const list[], int n,
                  duet_error *err)
{
    void *at[TIMELINE_SEEN] = {NULL};
    cl_int code = CL_SUCCESS;
    cl_event event = NULL;
    assert(n > 0 && n <= TIMELINE_SEEN);
    ++t->n_waits;
    if (t->device->driver.in_place)
        return await_queue(t, err);
    for (int i = 0; i < n && code == CL_SUCCESS; ++i) {
        bool last = i + 1 == n;
        if (list[i]->mem)
            at[i] = clEnqueueMapBuffer(t->device->queue, list[i]->mem, last, CL_MAP_READ, 0,
                                       list[i]->bytes, 0, NULL, last ? &event : NULL, &code);
    }
    for (int i = 0; i < n; ++i) {
        cl_int given =
            at[i] ? clEnqueueUnmapMemObject(t->device->queue, list[i]->mem, at[i], 0, NULL, NULL)
                  : CL_SUCCESS;
        code = code == CL_SUCCESS ? given : code;
    }
    bool kept = !event || keep_event(t, stage, true, event, err);
    if (code == CL_SUCCESS)
        code = clFlush(t->device->queue);
    t->unheard = code != CL_SUCCESS;
    t->seen = code == CL_SUCCESS;
    return kept && (code == CL_SUCCESS ||
                    error_set_cl(err, code, "%s: seeing what was found", t->device->info.selector));
}

cl_event timeline_last_event(const timeline *t)
{
    return t->n_events > 0 ? t->events[t->n_events - 1].event : NULL;
}

// Below 0 where the command failed, or where the device does not say.
static cl_int state_of(timeline *t, cl_event event)
{
    cl_int state = CL_COMPLETE;
    cl_int code =
        clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof state, &state, NULL);
    if (code != CL_SUCCESS)
        t->lost = state = code;
    return state;
}

// A command that failed is over too; finishing tells.
bool timeline_is_over(timeline *t, cl_event event)
{
    return state_of(t, event) <= CL_COMPLETE;
}

void timeline_spin(timeline *t, cl_event event)
{
    while (!timeline_is_over(t, event))
        sched_yield();
}

bool timeline_flush(timeline *t, duet_error *err)
{
    cl_int code = clFlush(t->device->queue);
    return code == CL_SUCCESS || error_set_cl(err, code, "%s: flush", t->device->info.selector);
}

static void add_event(timeline *t, duet_stage *stage, cl_event event)
{
    cl_ulong begin = 0;
    cl_ulong end = 0;
    clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof begin, &begin, NULL);
    clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL);
    if (end <= begin)
        return;
    stage->ms += (double)(end - begin) * 1e-6;
    if (stage->transfer)
        return;
    if (t->first_begin == 0 || begin < t->first_begin)
        t->first_begin = begin;
    if (end > t->last_end)
        t->last_end = end;
}

// Both, though one fails: nothing may be under way that reads memory of the host.
static cl_int finish_queues(timeline *t)
{
    cl_int code = clFinish(t->device->queue);
    cl_int beside = t->beside ? clFinish(t->device->beside) : CL_SUCCESS;
    t->beside = false;
    return code != CL_SUCCESS ? code : beside;
}

// Adds up and releases the first n events, which are over.
static cl_int collect(timeline *t, int n)
{
    cl_int code = CL_SUCCESS;
    for (int i = 0; i < n; ++i) {
        cl_event event = t->events[i].event;
        cl_int state = state_of(t, event);
        if (state < 0)
            code = state;
        else if (!t->untimed)
            add_event(t, &t->stages[t->events[i].stage], event);
        release(event);
    }
    t->n_events -= n;
    memmove(t->events, t->events + n, (size_t)t->n_events * sizeof t->events[0]);
    return code != CL_SUCCESS ? code : t->lost;
}

static bool ran_well(const timeline *t, cl_int code, duet_error *err)
{
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: running the step", t->device->info.selector);
}

bool timeline_collect_to(timeline *t, cl_event last, duet_error *err)
{
    int n = 0;
    while (n < t->n_events && t->events[n].event != last)
        ++n;
    return n == t->n_events || ran_well(t, collect(t, n + 1), err);
}

// A command without an event is over when a marker behind it is.
static cl_int mark_end(timeline *t, duet_error *err)
{
    cl_event event = NULL;
    cl_int code = clEnqueueMarkerWithWaitList(t->device->queue, 0, NULL, &event);
    if (code == CL_SUCCESS)
        keep_event(t, "end", true, event, err);
    return code;
}

bool timeline_finish(timeline *t, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    if (t->untimed && t->unheard && t->n_events < TIMELINE_EVENTS)
        code = mark_end(t, err);
    t->unheard = false;
    if (code == CL_SUCCESS && t->n_events > 0 && !t->device->info.host_memory) {
        code = clFlush(t->device->queue);
        if (code == CL_SUCCESS)
            timeline_spin(t, timeline_last_event(t));
    }
    cl_int finished = t->seen && !t->beside ? CL_SUCCESS : finish_queues(t);
    code = code != CL_SUCCESS ? code : finished;
    if (code == CL_SUCCESS)
        code = collect(t, t->n_events);
    timeline_clear(t);
    return ran_well(t, code, err);
}

void timeline_add_host(timeline *t, const char *stage, double ms)
{
    if (!t->untimed)
        t->stages[stage_index(t, stage, false)].ms += ms;
}

double timeline_kernel_ms(const timeline *t)
{
    return (double)(t->last_end - t->first_begin) * 1e-6;
}

int timeline_list_stages(const timeline *t, int side, duet_stage *list, int n)
{
    for (int i = 0; i < t->n_stages; ++i) {
        list[n] = t->stages[i];
        list[n++].device = side;
    }
    return n;
}

void timeline_clear(timeline *t)
{
    if (t->n_events > 0 || t->unheard)
        finish_queues(t);
    for (int i = 0; i < t->n_events; ++i)
        release(t->events[i].event);
    t->n_events = 0;
    t->unheard = false;
    t->lost = CL_SUCCESS;
}
