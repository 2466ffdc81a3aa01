// SPDX-License-Identifier: MIT
// Arrays in buffers of the caller's. A device of the buffer's context works on it in place; what
// another device needs or writes goes through the host's copy of the array.
#include "runtime/task/task_launcher.h"

#include "base/error.h"

// ---------------------------------------------------------------- binding

// The first device with the context that has work; B if it may.
static const device *find_owner(const task_launcher *l, const bool has[2])
{
    for (int side = 1; side >= 0; --side)
        if (has[side] && l->sides[side].side.device)
            return l->sides[side].side.device;
    return l->work.pair->devices + has[1];
}

// One device alone writes a buffer, since OpenCL promises nothing for two. Sums are added by the
// host.
static bool works_in_place(const task_launcher *l, uint32_t arg, int side, const bool has[2])
{
    const task_arg *a = &l->task->args[arg];
    const task_side *s = &l->sides[side];
    return has[side] && s->side.device && a->access != TASK_SUM &&
           (!task_arg_is_written(a) || s->side.device == l->bound[arg].device);
}

static void set_way(task_side *s, uint32_t arg, task_way way, cl_mem mem)
{
    s->ways[arg] = way;
    s->own.slots[arg].mem = mem;
}

void task_unbind(task_launcher *l, uint32_t arg)
{
    task_bound *b = &l->bound[arg];
    for (int side = 0; side < 2; ++side)
        set_way(&l->sides[side], arg, TASK_SENT_EACH, l->sides[side].buffers[arg].mem);
    callers_events_release(&b->events);
    mem_release(&b->mem);
    *b = (task_bound){0};
}

bool task_bind(task_launcher *l, uint32_t arg, cl_mem mem, cl_uint n_events, const cl_event *events,
               const char *call, duet_error *err)
{
    const task_arg *a = &l->task->args[arg];
    task_bound *b = &l->bound[arg];
    const device *devices = l->work.pair->devices;
    const buffer_need need = {.call = call,
                              .argument = a->name,
                              .use = task_arg_is_written(a) ? BUFFER_WRITTEN : BUFFER_READ,
                              .bytes = a->initial.size};
    callers_events waits = {0};
    bool has[2];
    if (!callers_buffer_check(mem, &need, devices, -1, has, err) ||
        !callers_events_check(n_events, events, devices[has[1]].context, call, err))
        return false;
    bool ok = callers_events_hold(&waits, n_events, events, err);
    for (int side = 0; ok && side < 2; ++side)
        ok = !has[side] || callers_events_mark(&waits, &devices[side], err);
    if (!ok) {
        callers_events_release(&waits);
        return false;
    }
    callers_buffer_hold(mem);
    task_unbind(l, arg);
    *b = (task_bound){.mem = mem, .device = find_owner(l, has), .events = waits};
    for (int side = 0; side < 2; ++side)
        if (works_in_place(l, arg, side, has))
            set_way(&l->sides[side], arg, TASK_IN_PLACE, mem);
    return true;
}

// ---------------------------------------------------------------- launches

typedef enum direction { TO_HOST, TO_BUFFER } direction;

static bool copy(task_launcher *l, uint32_t arg, direction way, size_t from, size_t to,
                 duet_error *err)
{
    const task_bound *b = &l->bound[arg];
    char *host = (char *)task_host_values(l, arg)->bytes + from;
    cl_int code = CL_SUCCESS;
    if (to > from)
        code = way == TO_HOST ? clEnqueueReadBuffer(b->device->queue, b->mem, CL_TRUE, from,
                                                    to - from, host, 0, NULL, NULL)
                              : clEnqueueWriteBuffer(b->device->queue, b->mem, CL_TRUE, from,
                                                     to - from, host, 0, NULL, NULL);
    return code == CL_SUCCESS || error_set_cl(err, code, "%s: a copy of %s in the caller's buffer",
                                              b->device->info.selector, l->task->args[arg].name);
}

// Copies what the sides that do not work in place have of an array.
static bool copy_parts(task_launcher *l, uint32_t arg, direction way, duet_error *err)
{
    bool ok = true;
    for (int side = 0; ok && side < 2; ++side) {
        const task_side *s = &l->sides[side];
        size_t from, to;
        if (s->ways[arg] != TASK_SENT_EACH || s->side.first == s->side.last)
            continue;
        task_arg_range(&l->task->args[arg], l->task->items, s->side.first, s->side.last, &from,
                       &to);
        ok = copy(l, arg, way, from, to, err);
    }
    return ok;
}

bool task_bound_load(task_launcher *l, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < l->task->n_args; ++i) {
        task_access access = l->task->args[i].access;
        if (!l->bound[i].mem)
            continue;
        ok = callers_events_wait(&l->bound[i].events, "the task's arrays", err) &&
             (access == TASK_OUT || access == TASK_SUM || copy_parts(l, i, TO_HOST, err));
    }
    return ok;
}

bool task_bound_store(task_launcher *l, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < l->task->n_args; ++i) {
        const task_arg *arg = &l->task->args[i];
        if (!l->bound[i].mem || !task_arg_is_written(arg))
            continue;
        ok = arg->access == TASK_SUM ? copy(l, i, TO_BUFFER, 0, arg->initial.size, err)
                                     : copy_parts(l, i, TO_BUFFER, err);
    }
    return ok;
}

bool task_bound_see(task_launcher *l, uint32_t arg, duet_error *err)
{
    return !l->bound[arg].mem ||
           (callers_events_wait(&l->bound[arg].events, "the task's arrays", err) &&
            copy(l, arg, TO_HOST, 0, l->task->args[arg].initial.size, err));
}
