// SPDX-License-Identifier: MIT
// The commands of a timeline.
#include "runtime/opencl/timeline.h"

#include "base/error.h"

#include <assert.h>

// Keeps a launch or a fill; event is NULL in an untimed step.
static bool keep_command(timeline *t, const char *stage, cl_event event, duet_error *err)
{
    t->sent = SENT_UNTOLD;
    return !event || timeline_keep(t, stage, false, event, err);
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
    t->sent = code == CL_SUCCESS ? SENT_SEEN : SENT_UNTOLD;
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: running the step", t->device->info.selector);
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
    return timeline_keep(t, stage, true, event, err);
}

// Keeps the event of a command on the queue beside, which begins at once.
static bool keep_beside(timeline *t, const char *stage, cl_event event, cl_int code,
                        const char *doing, size_t bytes, duet_error *err)
{
    if (code == CL_SUCCESS)
        code = clFlush(t->device->beside);
    t->beside = true;
    if (event && !timeline_keep(t, stage, true, event, err))
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
    if (wait)
        t->sent = SENT_TOLD;
    return timeline_keep(t, stage, true, event, err);
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
    bool kept = !event || timeline_keep(t, stage, true, event, err);
    if (code == CL_SUCCESS)
        code = clFlush(t->device->queue);
    t->sent = code == CL_SUCCESS ? SENT_SEEN : SENT_UNTOLD;
    return kept && (code == CL_SUCCESS ||
                    error_set_cl(err, code, "%s: seeing what was found", t->device->info.selector));
}
