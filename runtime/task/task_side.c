// SPDX-License-Identifier: MIT
#include "runtime/task/task_launcher.h"

#include <string.h>

// ---------------------------------------------------------------- ranges of arrays

// The byte at which the item's first element lies.
static size_t offset_of(const task_arg *arg, uint64_t item)
{
    return (size_t)(item * arg->per_item * arg->lanes) * task_scalar_bytes(arg->initial.scalar);
}

void task_arg_range(const task_arg *arg, uint64_t items, uint64_t first, uint64_t last,
                    size_t *from, size_t *to)
{
    *from = 0;
    *to = arg->initial.size;
    if (arg->per_item == 0 || arg->once)
        return;
    *from = offset_of(arg, first > arg->halo ? first - arg->halo : 0);
    *to = offset_of(arg, items - last > arg->halo ? last + arg->halo : items);
}

// ---------------------------------------------------------------- a device's part

task_values *task_host_values(task_launcher *l, uint32_t i)
{
    task_arg *arg = &l->task->args[i];
    return task_arg_is_written(arg) ? &l->results[i] : &arg->initial;
}

static bool send_array(task_side *s, uint32_t i, duet_error *err)
{
    const task *t = s->launcher->task;
    const task_arg *arg = &t->args[i];
    const task_values *v = task_host_values(s->launcher, i);
    buffer *b = &s->buffers[i];
    size_t from, to;
    if (s->ways[i] == TASK_IN_PLACE)
        return true;
    if (arg->access == TASK_SUM)
        return timeline_fill(&s->side.times, "send", b, 0, 0, arg->initial.size / 4, err);
    if (b->host)
        return timeline_write(&s->side.times, "send", b, b->host, arg->initial.size, err);
    if (arg->access == TASK_OUT || s->ways[i] == TASK_SENT)
        return true;
    task_arg_range(arg, t->items, s->side.first, s->side.last, &from, &to);
    s->ways[i] = arg->once ? TASK_SENT : TASK_SENT_EACH;
    return timeline_write_at(&s->side.times, "send", b, from, (const char *)v->bytes + from,
                             to - from, err);
}

bool task_set_number(task_launcher *l, uint32_t arg, duet_error *err)
{
    bool ok = true;
    for (int side = 0; ok && side < 2; ++side)
        ok = !l->sides[side].side.device ||
             task_call_set_number(&l->sides[side].own, l->task, arg, err);
    return ok;
}

bool task_side_send(task_side *s, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < s->launcher->task->n_args; ++i)
        ok = s->launcher->task->args[i].kind != TASK_ARG_ARRAY || send_array(s, i, err);
    return ok;
}

// Work-units along each axis of the kernel: the items lie along the last one.
static void list_units(const task_side *s, uint64_t units[3])
{
    const task *t = s->launcher->task;
    uint64_t items = s->side.last - s->side.first;
    const uint64_t of[3][3] = {
        {items * t->work, 1, 1}, {t->work, items, 1}, {t->wide, t->work / t->wide, items}};
    memcpy(units, of[s->kernel->n_axes - 1], sizeof of[0]);
}

bool task_side_launch(task_side *s, duet_error *err)
{
    uint64_t units[3];
    task_call_aim(s->call, s->launcher->task, s->side.first, s->side.last);
    list_units(s, units);
    return timeline_launch_grid(&s->side.times, "kernel", s->kernel, units, s->call->slots, err);
}
