// SPDX-License-Identifier: MIT
// The commands that a timeline sends, and how the host waits for them.
#include "runtime/opencl/timeline.h"

#include "base/clock.h"
#include "base/error.h"

#include <assert.h>
#include <sched.h>
#include <string.h>

// ---------------------------------------------------------------- under way

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
    t->begun_ns = clock_steady_ns();
    t->n_tied = 0;
}

void timeline_begin_step(timeline *t, const device *d, uint64_t step)
{
    timeline_begin(t, d,
                   d->info.host_memory || t->n_stages == 0 || step % TIMELINE_TIMED_EVERY == 0);
}

static bool went_well(const timeline *t, cl_int code, const char *doing, duet_error *err)
{
    return code == CL_SUCCESS || error_set_cl(err, code, "%s: %s", t->device->info.selector, doing);
}

static bool moved(const timeline *t, cl_int code, const char *doing, size_t bytes, duet_error *err)
{
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: %s %zu bytes", t->device->info.selector, doing, bytes);
}

static void release(cl_event event)
{
    clReleaseEvent(event);
    device_object_gone();
}

// Waits for the queue once the list is full, so that any number fits.
static bool keep(timeline *t, const char *stage, bool transfer, cl_event event, duet_error *err)
{
    int at = t->untimed ? 0 : timeline_stage(t, stage, transfer);
    device_object_made();
    if (t->sent == SENT_SEEN)
        t->sent = SENT_TOLD;
    if (t->n_events == TIMELINE_EVENTS && !timeline_finish(t, err)) {
        release(event);
        return false;
    }
    t->events[t->n_events].stage = at;
    t->events[t->n_events].event = event;
    t->events[t->n_events].sent_ns = t->untimed ? 0 : clock_steady_ns();
    ++t->n_events;
    return true;
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

// Before the host waits.
static void let_go(timeline *t)
{
    if (!t->held)
        return;
    clSetUserEventStatus(t->held, CL_COMPLETE);
    release(t->held);
    t->held = NULL;
}

void timeline_spin(timeline *t, cl_event event)
{
    let_go(t);
    while (!timeline_is_over(t, event))
        sched_yield();
}

bool timeline_hold(timeline *t, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    if (t->held || !(t->device->quirks & DRIVER_IN_PLACE))
        return true;
    t->held = clCreateUserEvent(t->device->context, &code);
    if (!went_well(t, code, "making an event", err))
        return false;
    device_object_made();
    t->sent = SENT_UNTOLD;
    return timeline_follow(t, t->held, err);
}

bool timeline_flush(timeline *t, duet_error *err)
{
    let_go(t);
    return went_well(t, clFlush(t->device->queue), "flush", err);
}

// Both, though one fails: nothing may be under way that reads memory of the host.
static cl_int finish_queues(timeline *t)
{
    let_go(t);
    cl_int code = clFinish(t->device->queue);
    cl_int beside = t->beside ? clFinish(t->device->beside) : CL_SUCCESS;
    t->beside = false;
    return code != CL_SUCCESS ? code : beside;
}

// Adds up and releases the first n events, which are over.
static cl_int collect(timeline *t, int n)
{
    cl_int code = CL_SUCCESS;
    if (!t->untimed)
        timeline_add_times(t, n);
    for (int i = 0; i < n; ++i) {
        cl_int state = state_of(t, t->events[i].event);
        code = state < 0 ? state : code;
        release(t->events[i].event);
    }
    t->n_events -= n;
    memmove(t->events, t->events + n, (size_t)t->n_events * sizeof t->events[0]);
    return code != CL_SUCCESS ? code : t->lost;
}

bool timeline_collect_to(timeline *t, cl_event last, duet_error *err)
{
    int n = 0;
    while (n < t->n_events && t->events[n].event != last)
        ++n;
    return n == t->n_events || went_well(t, collect(t, n + 1), "running the step", err);
}

// A command without an event is over when a marker behind it is.
static cl_int mark_end(timeline *t, duet_error *err)
{
    cl_event event = NULL;
    cl_int code = clEnqueueMarkerWithWaitList(t->device->queue, 0, NULL, &event);
    if (code == CL_SUCCESS)
        keep(t, "end", true, event, err);
    return code;
}

// Does the reads that were asked for, once the host has waited.
static void take_asked(timeline *t)
{
    for (int i = 0; i < t->n_asked; ++i)
        memcpy(t->asked[i].to, t->asked[i].from, t->asked[i].bytes);
    t->n_asked = 0;
}

bool timeline_finish(timeline *t, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    if (t->untimed && t->sent == SENT_UNTOLD && t->n_events < TIMELINE_EVENTS)
        code = mark_end(t, err);
    if (t->sent == SENT_UNTOLD)
        t->sent = SENT_TOLD;
    if (code == CL_SUCCESS && t->n_events > 0 && !t->device->info.host_memory) {
        code = clFlush(t->device->queue);
        if (code == CL_SUCCESS)
            timeline_spin(t, timeline_last_event(t));
    }
    const bool waits = t->sent != SENT_SEEN || t->beside;
    cl_int finished = waits ? finish_queues(t) : CL_SUCCESS;
    t->all_waits += waits;
    code = code != CL_SUCCESS ? code : finished;
    if (code == CL_SUCCESS)
        code = collect(t, t->n_events);
    if (code == CL_SUCCESS)
        take_asked(t);
    timeline_clear(t);
    return went_well(t, code, "running the step", err);
}

void timeline_clear(timeline *t)
{
    if (t->n_events > 0 || t->sent == SENT_UNTOLD)
        finish_queues(t);
    for (int i = 0; i < t->n_events; ++i)
        release(t->events[i].event);
    t->n_events = t->n_asked = 0;
    if (t->sent == SENT_UNTOLD)
        t->sent = SENT_TOLD;
    t->lost = CL_SUCCESS;
}

// ---------------------------------------------------------------- commands

// Keeps a launch or a fill; event is NULL in an untimed step.
static bool keep_command(timeline *t, const char *stage, cl_event event, duet_error *err)
{
    t->sent = SENT_UNTOLD;
    return !event || keep(t, stage, false, event, err);
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

// The groups along each axis; the last one becomes the third if the driver asks for that.
static void count_groups(const timeline *t, const kernel *k, const uint64_t units[3], size_t n[3])
{
    const gen_axis axes[3] = {{k->group, k->per_item}, k->more[0], k->more[1]};
    for (int i = 0; i < 3; ++i) {
        uint64_t per_group = (uint64_t)axes[i].group * axes[i].per_item;
        n[i] = (size_t)((units[i] + per_group - 1) / per_group);
    }
    if ((t->device->quirks & DRIVER_TWO_WIDTHS) && k->n_axes < 3) {
        n[2] = n[k->n_axes - 1];
        n[k->n_axes - 1] = 1;
    }
}

static bool launch(timeline *t, const char *stage, const kernel *k, const uint64_t units[3],
                   cl_event after, const void *values, duet_error *err)
{
    if (units[k->n_axes - 1] == 0)
        return true;
    if (!set_args(k, values, t->device, err))
        return false;
    const size_t group[3] = {k->group, k->more[0].group, k->more[1].group};
    size_t n[3];
    count_groups(t, k, units, n);
    const size_t items[3] = {n[0] * group[0], n[1] * group[1], n[2] * group[2]};
    cl_event event = NULL;
    cl_int code =
        clEnqueueNDRangeKernel(t->device->queue, k->cl, 3, NULL, items, group, after ? 1 : 0,
                               after ? &after : NULL, t->untimed ? NULL : &event);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s on %s: launch", k->name, t->device->info.selector);
    ++t->n_launches;
    ++t->all_launches;
    return keep_command(t, stage, event, err);
}

bool timeline_launch(timeline *t, const char *stage, const kernel *k, uint64_t work,
                     const void *values, duet_error *err)
{
    return timeline_launch_after(t, stage, k, work, NULL, values, err);
}

bool timeline_launch_after(timeline *t, const char *stage, const kernel *k, uint64_t work,
                           cl_event after, const void *values, duet_error *err)
{
    const uint64_t units[3] = {work, 1, 1};
    return launch(t, stage, k, units, after, values, err);
}

bool timeline_launch_grid(timeline *t, const char *stage, const kernel *k, const uint64_t units[3],
                          const void *values, duet_error *err)
{
    return launch(t, stage, k, units, NULL, values, err);
}

// ---------------------------------------------------------------- in place

static bool is_in_place(const timeline *t, const buffer *b)
{
    return b->host && (t->device->quirks & DRIVER_IN_PLACE);
}

// Whether the host may change the buffer itself, which a command would wake a CPU's threads for:
// it has seen the end of all that it sent. Another timeline's commands on the queue are waited for.
static bool lies_still(const timeline *t, const buffer *b)
{
    return is_in_place(t, b) && t->sent == SENT_SEEN && !t->beside &&
           clFinish(t->device->queue) == CL_SUCCESS;
}

// If kernels work in place, the host sees all once the queue is empty.
static bool await_queue(timeline *t, duet_error *err)
{
    let_go(t);
    cl_int code = clFinish(t->device->queue);
    t->sent = code == CL_SUCCESS ? SENT_SEEN : SENT_UNTOLD;
    if (code == CL_SUCCESS)
        take_asked(t);
    return went_well(t, code, "running the step", err);
}

// Reads when the host waits next.
static bool ask_in_place(timeline *t, const buffer *b, size_t at, void *to, size_t bytes)
{
    if (!is_in_place(t, b) || t->n_asked == TIMELINE_ASKED)
        return false;
    t->asked[t->n_asked].from = (const char *)b->host + at;
    t->asked[t->n_asked].to = to;
    t->asked[t->n_asked++].bytes = bytes;
    return true;
}

// ---------------------------------------------------------------- copies

bool timeline_fill(timeline *t, const char *stage, buffer *b, uint32_t value, size_t from,
                   size_t to, duet_error *err)
{
    if (from == to)
        return true;
    if (lies_still(t, b)) {
        for (size_t i = from; i < to; ++i)
            ((uint32_t *)b->host)[i] = value;
        return true;
    }
    cl_event event = NULL;
    cl_int code =
        clEnqueueFillBuffer(t->device->queue, b->mem, &value, sizeof value, from * sizeof value,
                            (to - from) * sizeof value, 0, NULL, t->untimed ? NULL : &event);
    return went_well(t, code, "filling a buffer", err) && keep_command(t, stage, event, err);
}

// Hands wrapped host memory from one side to the other without moving it. A wait here costs a
// CPU's driver two wake-ups, a tenth of a millisecond.
static bool hand_over(timeline *t, buffer *b, cl_map_flags flags, size_t bytes, cl_bool wait,
                      duet_error *err)
{
    cl_int code = CL_SUCCESS;
    if (t->device->quirks & DRIVER_IN_PLACE)
        return !wait || await_queue(t, err);
    if (t->sent == SENT_SEEN)
        t->sent = SENT_TOLD;
    void *seen =
        clEnqueueMapBuffer(t->device->queue, b->mem, wait, flags, 0, bytes, 0, NULL, NULL, &code);
    if (seen)
        code = clEnqueueUnmapMemObject(t->device->queue, b->mem, seen, 0, NULL, NULL);
    return moved(t, code, "mapping", bytes, err);
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
    if (lies_still(t, b)) {
        memcpy((char *)b->host + at, from, bytes);
        return true;
    }
    cl_event event = NULL;
    cl_int code =
        clEnqueueWriteBuffer(t->device->queue, b->mem, CL_FALSE, at, bytes, from, 0, NULL, &event);
    return moved(t, code, "sending", bytes, err) && keep(t, stage, true, event, err);
}

// Keeps the event of a command on the queue beside, which begins at once.
static bool keep_beside(timeline *t, const char *stage, cl_event event, cl_int code,
                        const char *doing, size_t bytes, duet_error *err)
{
    if (code == CL_SUCCESS)
        code = clFlush(t->device->beside);
    t->beside = true;
    return (!event || keep(t, stage, true, event, err)) && moved(t, code, doing, bytes, err);
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
    return went_well(t, code, "waiting for what was sent", err);
}

static bool enqueue_read(timeline *t, const char *stage, buffer *b, size_t at, void *to,
                         size_t bytes, cl_bool wait, duet_error *err)
{
    if (bytes == 0)
        return true;
    t->n_waits += wait;
    t->all_waits += wait;
    if (wait)
        let_go(t);
    if (b->host == to)
        return hand_over(t, b, CL_MAP_READ, bytes, wait, err);
    if (ask_in_place(t, b, at, to, bytes))
        return !wait || await_queue(t, err);
    cl_event event = NULL;
    cl_int code =
        clEnqueueReadBuffer(t->device->queue, b->mem, wait, at, bytes, to, 0, NULL, &event);
    if (!moved(t, code, "fetching", bytes, err))
        return false;
    if (wait) {
        t->sent = SENT_TOLD;
        take_asked(t);
    }
    return keep(t, stage, true, event, err);
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
    ++t->all_waits;
    if (t->device->quirks & DRIVER_IN_PLACE)
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
    bool kept = !event || keep(t, stage, true, event, err);
    if (code == CL_SUCCESS)
        code = clFlush(t->device->queue);
    t->sent = code == CL_SUCCESS ? SENT_SEEN : SENT_UNTOLD;
    return kept && went_well(t, code, "seeing what was found", err);
}
