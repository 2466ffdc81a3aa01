// SPDX-License-Identifier: MIT
#include "cli/report/level_costs_show.h"

#include "cli/interrupt.h"
#include "cli/progress.h"

static bool watch(void *shown, uint64_t done, uint64_t steps)
{
    progress *p = shown;
    p->total = steps;
    progress_show(p, done);
    return !interrupt_asked();
}

bool level_costs_show(level_costs *p, duet_device_pair *pair, const duet_scene *scene,
                      uint32_t rounds, duet_error *err)
{
    progress shown = progress_begin("step", 0);
    level_costs_def def = {.pair = pair,
                           .scene = scene,
                           .alone = true,
                           .rounds = rounds,
                           .watch = watch,
                           .watch_context = &shown};
    bool ok = level_costs_measure(p, &def, err);
    progress_end(&shown);
    return ok;
}
