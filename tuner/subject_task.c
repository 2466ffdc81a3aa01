// SPDX-License-Identifier: MIT
// A task as a subject: a kernel of the user's, whose items two devices share. Every launch is
// checked against what is right, within the task's tolerance: there is no hash.
#include "tuner/subject.h"

#include "runtime/task/task_launch.h"

#include <stdio.h>
#include <string.h>

static bool open(subject *s, duet_error *err)
{
    task *t = s->def->task;
    const char *device = duet_device_pair_get_info(s->pair, 1)->name;
    bool checked = strcmp(t->checked_on, device) == 0; // with parts of this device
    s->units = t->items;
    s->state = checked ? task_launcher_open_unchecked(t, s->pair, err)
                       : task_launcher_open(t, s->pair, err);
    s->launch_ms = s->state && !checked ? task_launcher_estimate_ms(s->state) : 0;
    if (s->state)
        snprintf(t->checked_on, sizeof t->checked_on, "%s", device);
    return s->state;
}

static void close(subject *s)
{
    task_launcher_close(s->state);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    if (!profile_subject_read_task(s->def->task, s->pair, p, err))
        return false;
    p->workload.name = s->def->task->name;
    return true;
}

static bool launch(void *context, const duet_plan *plan, bool staged, measure_launch *out,
                   duet_error *err)
{
    subject *s = context;
    task_result r;
    (void)staged;
    task_launch_reset(s->state, plan);
    measure_watch(s->cores, s->pair); // resetting and checking are not in the time
    if (!task_launch_unchecked(s->state, plan, &r, err))
        return false;
    *out = (measure_launch){.total_ns = measure_to_ns(r.total_ms),
                            .a_ns = measure_to_ns(r.device_ms[0]),
                            .b_ns = measure_to_ns(r.device_ms[1]),
                            .use = core_watch_stop(s->cores)};
    measure_take_stages(out, r.stages, r.n_stages);
    return task_launch_check(s->state, err);
}

static void set_part(void *context, uint32_t part)
{
    task_launcher_set_part(((subject *)context)->state, part);
}

static bool train(void *context, const duet_plan *plan, uint32_t n, duet_error *err)
{
    return task_launch_train(((subject *)context)->state, plan, n, err);
}

static bool read_kernels(void *context, const duet_plan *plan, int side, kernel_spaces *to,
                         duet_error *err)
{
    return task_kernel_space(((subject *)context)->state, plan, side, to, err);
}

const subject_kind subject_task = {
    .has = "a task has",
    .asked_by = SUBJECT_TASK,
    .takes = SUBJECT_TASK | SUBJECT_SEARCH | SUBJECT_VARIANTS,
    .searches = true,
    .has_one_way = true,
    .open = open,
    .close = close,
    .describe = describe,
    .machine = {.launch = launch,
                .train = train,
                .read_kernels = read_kernels,
                .set_part = set_part},
};
