// SPDX-License-Identifier: MIT
// The events of a timeline: kept by their stages, waited for, and their times read.
#include "runtime/opencl/timeline.h"

#include "base/clock.h"
#include "base/error.h"

#include <assert.h>
#include <math.h>
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
    t->begun_ns = clock_steady_ns();
    t->n_tied = 0;
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
    t->on_host[t->n_stages] = false;
    return t->n_stages++;
}

static void release(cl_event event)
{
    clReleaseEvent(event);
    device_object_gone();
}

// Waits for the queue once the list is full, so that any number fits.
bool timeline_keep(timeline *t, const char *stage, bool transfer, cl_event event, duet_error *err)
{
    int at = t->untimed ? 0 : stage_index(t, stage, transfer);
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

static double host_ms(const timeline *t, cl_ulong device_ns)
{
    return (double)((int64_t)(device_ns - t->queued) + t->first_ns) * 1e-6;
}

static void move_stages(timeline *t, double ms)
{
    for (int i = 0; i < t->n_stages; ++i) {
        bool moves = !t->on_host[i] && t->stages[i].end_ms != 0;
        t->stages[i].begin_ms += moves ? ms : 0;
        t->stages[i].end_ms += moves ? ms : 0;
    }
}

// A device's clock counts from a moment of its own. Each of the first commands was queued before
// the host saw that it was sent, mostly just before; the one with the least delay says when.
static void tie_clocks(timeline *t, int i)
{
    cl_ulong queued = 0;
    clGetEventProfilingInfo(t->events[i].event, CL_PROFILING_COMMAND_QUEUED, sizeof queued, &queued,
                            NULL);
    bool first = t->n_tied++ == 0;
    t->queued = first ? queued : t->queued;
    int64_t sent_ns = (int64_t)(t->events[i].sent_ns - t->begun_ns);
    int64_t first_ns = sent_ns - (int64_t)(queued - t->queued);
    if (!first && first_ns >= t->first_ns)
        return;
    if (!first)
        move_stages(t, (double)(first_ns - t->first_ns) * 1e-6);
    t->first_ns = first_ns;
}

static void extend_stage(duet_stage *stage, double begin_ms, double end_ms)
{
    bool first = stage->end_ms == 0;
    stage->begin_ms = first ? begin_ms : fmin(stage->begin_ms, begin_ms);
    stage->end_ms = first ? end_ms : fmax(stage->end_ms, end_ms);
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
    extend_stage(stage, host_ms(t, begin), host_ms(t, end));
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
    for (int i = 0; i < n && !t->untimed && t->n_tied < TIMELINE_TIED; ++i)
        tie_clocks(t, i);
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
        timeline_keep(t, "end", true, event, err);
    return code;
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
    cl_int finished = t->sent == SENT_SEEN && !t->beside ? CL_SUCCESS : finish_queues(t);
    code = code != CL_SUCCESS ? code : finished;
    if (code == CL_SUCCESS)
        code = collect(t, t->n_events);
    timeline_clear(t);
    return ran_well(t, code, err);
}

void timeline_add_host(timeline *t, const char *stage, double ms)
{
    if (t->untimed)
        return;
    int i = stage_index(t, stage, false);
    duet_stage *at = &t->stages[i];
    t->on_host[i] |= at->end_ms == 0;
    double end_ms = clock_ms_since(t->begun_ns);
    at->ms += ms;
    extend_stage(at, end_ms - ms, end_ms);
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
    if (t->n_events > 0 || t->sent == SENT_UNTOLD)
        finish_queues(t);
    for (int i = 0; i < t->n_events; ++i)
        release(t->events[i].event);
    t->n_events = 0;
    if (t->sent == SENT_UNTOLD)
        t->sent = SENT_TOLD;
    t->lost = CL_SUCCESS;
}
