// SPDX-License-Identifier: MIT
#include "cli/timed_task.h"

#include "base/error.h"
#include "cli/interrupt.h"
#include "tuner/measure.h"

#include <stdlib.h>
#include <string.h>

static bool keep_launch(timed *t, const task_result *r, duet_error *err)
{
    timed_step *step = &t->steps[t->n];
    step->stages = calloc(r->n_stages + 1, sizeof *step->stages);
    if (!step->stages)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the times of a launch: no memory");
    memcpy(step->stages, r->stages, r->n_stages * sizeof *step->stages);
    step->n_stages = r->n_stages;
    step->total_ms = r->total_ms;
    memcpy(step->device_ms, r->device_ms, sizeof step->device_ms);
    ++t->n;
    return true;
}

static bool launch(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                   core_watch *cores, duet_error *err)
{
    task_result r;
    task_launch_reset(l);
    measure_watch(cores, pair); // resetting and checking are not in the time
    if (!task_launch_unchecked(l, plan, &r, err))
        return false;
    core_watch_stop(cores);
    return task_launch_check(l, err) && keep_launch(t, &r, err);
}

static int by_time(const void *a, const void *b)
{
    double x = ((const timed_step *)a)->total_ms, y = ((const timed_step *)b)->total_ms;
    return (x > y) - (x < y);
}

bool timed_task_run(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                    uint32_t repeat, duet_error *err)
{
    task_result first;
    t->steps = calloc(repeat, sizeof *t->steps);
    if (!t->steps)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the times of %u launches: no memory", repeat);
    core_watch *cores = core_watch_open();
    bool ok = task_launch(l, plan, &first, err);
    while (ok && t->n < repeat && !interrupt_asked())
        ok = launch(t, l, pair, plan, cores, err);
    t->cores = core_watch_tally(cores);
    core_watch_close(cores);
    qsort(t->steps, t->n, sizeof *t->steps, by_time);
    return ok && (t->n > 0 || interrupt_check(err));
}
