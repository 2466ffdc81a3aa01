// SPDX-License-Identifier: MIT
// A launch whose written arrays lie between guards, and hold a pattern outside the device's items:
// whatever the kernel changes of these, it should not have written.
#include "runtime/task/task_launcher.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>

enum { GUARD = 4096, PATTERN = 0xA5 }; // bytes before and behind an array

typedef struct guarded {
    buffer whole; // guard, array, guard
    cl_mem array; // the part of it that the kernel gets
    unsigned char *seen;
} guarded;

static size_t whole_bytes(const task_arg *arg)
{
    return GUARD + (arg->initial.size + 3) / 4 * 4 + GUARD;
}

// The bytes that the side may write, in the array.
static void allowed(const task_side *s, const task_arg *arg, size_t *from, size_t *to)
{
    task_arg_range(arg, s->launcher->task->items, s->side.first, s->side.last, from, to);
}

static bool fill(task_side *s, const task_arg *arg, guarded *g, duet_error *err)
{
    const uint32_t word = PATTERN * 0x01010101u;
    size_t from, to;
    allowed(s, arg, &from, &to);
    timeline *t = &s->side.times;
    if (!timeline_fill(t, "guard", &g->whole, word, 0, whole_bytes(arg) / 4, err))
        return false;
    if (arg->access == TASK_SUM)
        return timeline_fill(t, "guard", &g->whole, 0, GUARD / 4, (GUARD + arg->initial.size) / 4,
                             err);
    return arg->access != TASK_IN_OUT ||
           timeline_write_at(t, "guard", &g->whole, GUARD + from,
                             (const char *)arg->initial.bytes + from, to - from, err);
}

static bool make(task_side *s, const task_arg *arg, guarded *g, duet_error *err)
{
    const cl_buffer_region region = {GUARD, arg->initial.size};
    cl_int code = CL_SUCCESS;
    g->seen = malloc(whole_bytes(arg));
    if (!g->seen)
        return no_memory(err, "guards of %s", arg->name);
    if (!buffer_reserve(&g->whole, s->side.device, whole_bytes(arg), err))
        return false;
    g->array = clCreateSubBuffer(g->whole.mem, CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION,
                                 &region, &code);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: guards of %s", s->side.device->info.selector,
                            arg->name);
    return fill(s, arg, g, err);
}

static bool tell(const task_side *s, const task_arg *arg, size_t at, duet_error *err)
{
    size_t element = arg->initial.size / arg->count;
    int64_t i = at >= GUARD ? (int64_t)((at - GUARD) / element)
                            : -(int64_t)((GUARD - at + element - 1) / element);
    return error_set(err, DUET_STATUS_WRONG_RESULT,
                     "task %s: on %s the kernel writes %s[%" PRId64 "], which does not belong to "
                     "its items, %" PRIu64 " to %" PRIu64,
                     s->launcher->task->name, s->side.device->info.selector, arg->name, i,
                     s->side.first, s->side.last - 1);
}

static bool look(task_side *s, const task_arg *arg, guarded *g, duet_error *err)
{
    size_t from, to, n = whole_bytes(arg);
    allowed(s, arg, &from, &to);
    if (!timeline_read_at(&s->side.times, "guard", &g->whole, 0, g->seen, n, err))
        return false;
    for (size_t i = 0; i < n; ++i)
        if ((i < GUARD + from || i >= GUARD + to) && g->seen[i] != PATTERN)
            return tell(s, arg, i, err);
    return true;
}

static bool each(task_side *s, guarded *list,
                 bool (*act)(task_side *, const task_arg *, guarded *, duet_error *),
                 duet_error *err)
{
    const task *t = s->launcher->task;
    bool ok = true;
    for (uint32_t i = 0; ok && i < t->n_args; ++i)
        ok = !task_arg_is_written(&t->args[i]) || act(s, &t->args[i], &list[i], err);
    return ok;
}

// Lends the kernel the guarded arrays, or takes them back.
static void exchange(task_side *s, guarded *list)
{
    for (uint32_t i = 0; i < s->launcher->task->n_args; ++i) {
        cl_mem other = list[i].array;
        if (!other)
            continue;
        list[i].array = s->call->slots[i].mem;
        s->call->slots[i].mem = other;
    }
}

static bool run_guarded(work_side *w)
{
    task_side *s = (task_side *)w;
    guarded list[GEN_MAX_ARGS] = {0};
    bool ok = each(s, list, make, &w->err) && task_side_send(s, &w->err);
    exchange(s, list);
    ok = ok && task_side_launch(s, &w->err);
    exchange(s, list);
    ok = ok && each(s, list, look, &w->err);
    duet_error late = {0};
    timeline_finish(&s->side.times, &late);
    s->guarded_ms = timeline_kernel_ms(&s->side.times);
    for (uint32_t i = 0; i < GEN_MAX_ARGS; ++i) {
        if (list[i].array)
            clReleaseMemObject(list[i].array);
        buffer_release(&list[i].whole);
        free(list[i].seen);
    }
    return ok;
}

bool task_guard_check(task_launcher *l, uint32_t share, duet_error *err)
{
    l->work.share = share;
    return shared_work_run(&l->work, l->task->items, run_guarded, err);
}
