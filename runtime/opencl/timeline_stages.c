// SPDX-License-Identifier: MIT
// How long the stages of a timeline took, by the host's clock and the device's.
#include "runtime/opencl/timeline.h"

#include "base/clock.h"

#include <assert.h>
#include <math.h>
#include <string.h>

int timeline_stage(timeline *t, const char *name, bool transfer)
{
    for (int i = 0; i < t->n_stages; ++i)
        if (strcmp(t->stages[i].name, name) == 0)
            return i;
    assert(t->n_stages < TIMELINE_STAGES);
    t->stages[t->n_stages] = (duet_stage){.name = name, .transfer = transfer};
    t->on_host[t->n_stages] = false;
    return t->n_stages++;
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

// A command that failed has no times.
void timeline_add_times(timeline *t, int n)
{
    for (int i = 0; i < n && t->n_tied < TIMELINE_TIED; ++i)
        tie_clocks(t, i);
    for (int i = 0; i < n; ++i)
        add_event(t, &t->stages[t->events[i].stage], t->events[i].event);
}

void timeline_add_host(timeline *t, const char *stage, double ms)
{
    if (t->untimed)
        return;
    int i = timeline_stage(t, stage, false);
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
