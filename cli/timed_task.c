// SPDX-License-Identifier: MIT
#include "cli/timed_task.h"

#include "base/error.h"
#include "cli/interrupt.h"
#include "tuner/measure.h"

#include <stdlib.h>

static bool launch(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                   core_watch *cores, duet_error *err)
{
    task_result r;
    task_launch_reset(l, plan);
    measure_watch(cores, pair); // resetting and checking are not in the time
    if (!task_launch_unchecked(l, plan, &r, err))
        return false;
    core_watch_stop(cores);
    const duet_result times = {.total_ms = r.total_ms,
                               .device_ms = {r.device_ms[0], r.device_ms[1]},
                               .stages = r.stages,
                               .n_stages = r.n_stages};
    return task_launch_check(l, err) && timed_add(t, &t->n, &times, err);
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
    timed_sort(t);
    return ok && (t->n > 0 || interrupt_check(err));
}
