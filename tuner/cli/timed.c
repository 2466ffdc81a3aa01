// SPDX-License-Identifier: MIT
#include "tuner/cli/timed.h"

#include "runtime/base/error.h"
#include "tuner/cli/interrupt.h"
#include "tuner/cli/progress.h"

#include <stdlib.h>

static bool keep_step(timed *t, const duet_result *result, duet_error *err)
{
    timed_step *step = &t->steps[t->n];
    step->stages = calloc(result->n_stages + 1, sizeof *step->stages);
    if (!step->stages)
        return error_set(err, DUET_NO_MEMORY, "the times of a step: no memory");
    for (uint32_t i = 0; i < result->n_stages; ++i)
        step->stages[i] = result->stages[i];
    step->n_stages = result->n_stages;
    step->total_ms = result->total_ms;
    step->device_ms[0] = result->device_ms[0];
    step->device_ms[1] = result->device_ms[1];
    ++t->n;
    return true;
}

static int by_time(const void *a, const void *b)
{
    double x = ((const timed_step *)a)->total_ms;
    double y = ((const timed_step *)b)->total_ms;
    return (x > y) - (x < y);
}

bool timed_run(timed *t, duet_world *world, uint32_t repeat, duet_error *err)
{
    t->steps = calloc(repeat, sizeof *t->steps);
    if (!t->steps)
        return error_set(err, DUET_NO_MEMORY, "the times of %u steps: no memory", repeat);
    bool ok = duet_world_step(world, &t->last, err);
    t->hash = ok ? duet_result_hash(&t->last) : 0;
    progress p = progress_begin("step", repeat);
    while (ok && t->n < repeat && !interrupt_asked()) {
        ok = duet_world_step(world, &t->last, err) && keep_step(t, &t->last, err);
        if (ok && duet_result_hash(&t->last) != t->hash)
            ok =
                error_set(err, DUET_WRONG_RESULT, "step %u found other pairs than the first", t->n);
        progress_show(&p, t->n);
    }
    progress_end(&p);
    if (ok && t->n == 0)
        ok = interrupt_check(err);
    if (t->n > 0)
        qsort(t->steps, t->n, sizeof *t->steps, by_time);
    return ok;
}

void timed_free(timed *t)
{
    for (uint32_t i = 0; i < t->n; ++i)
        free(t->steps[i].stages);
    free(t->steps);
}

const timed_step *timed_median(const timed *t)
{
    return &t->steps[(t->n - 1) / 2];
}
