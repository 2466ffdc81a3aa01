// SPDX-License-Identifier: MIT
#include "tuner/tune.h"

#include "tuner/kernel_tuning.h"
#include "tuner/variants.h"
#include "tuner/verdict.h"

static const char *const default_variants[] = {"auto", "simd", "auto sort=radix", "paper"};

const char *task_variant(const duet_tune_def *def, uint32_t i)
{
    enum { N_DEFAULT = sizeof default_variants / sizeof *default_variants };
    if (def->n_variants > 0)
        return i < def->n_variants ? def->variants[i] : NULL;
    return i < N_DEFAULT ? default_variants[i] : NULL;
}

uint32_t task_count_variants(const duet_tune_def *def)
{
    uint32_t n = 0;
    while (task_variant(def, n))
        ++n;
    return n;
}

uint32_t task_count_modes(const duet_tune_def *def)
{
    enum { EACH = DUET_MODE_DEFAULT };
    return def->n_modes > 0 && def->n_modes < EACH ? def->n_modes : EACH;
}

bool tune_run(const tune_task *task, trial_log *state, duet_tune_outcome *outcome, duet_error *err)
{
    tuning t = {.task = task, .state = state, .plan = task->plan, .repeats = task->def->repeats};
    mode_found founds[MOST_MODES] = {0};
    uint32_t n = 0;
    state->played = 0;
    *outcome = (duet_tune_outcome){0};
    bool ok = variants_choose(&t, err) && kernel_tuning_run(&t, outcome->kernels, err) &&
              mode_search_run(&t, founds, &n, err) && verdict_reach(&t, founds, n, outcome, err) &&
              verdict_race_whole(&t, outcome, err);
    outcome->trials = state->played + t.unlogged;
    outcome->launches = t.launches;
    outcome->seconds = (double)t.spent_ns * 1e-9;
    return ok;
}
