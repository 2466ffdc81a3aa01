// SPDX-License-Identifier: MIT
#include "tuner/tune.h"

#include "tuner/kernel_tuning.h"
#include "tuner/variants.h"
#include "tuner/verdict.h"

#include <math.h>

bool tune_run(const tune_task *task, trial_log *state, duet_tune_outcome *outcome, duet_error *err)
{
    tuning t = {.task = task, .state = state, .plan = task->plan, .repeats = task->def->repeats};
    mode_found founds[MOST_MODES] = {0};
    uint32_t n = 0;
    state->played = 0;
    *outcome = (duet_tune_outcome){.single_ms = NAN,
                                   .whole_ms = NAN,
                                   .whole_gain = NAN,
                                   .whole_gain_low = NAN,
                                   .whole_gain_high = NAN};
    bool ok = variants_choose(&t, err) && kernel_tuning_run(&t, outcome->kernels, err) &&
              mode_search_run(&t, founds, &n, err) && verdict_reach(&t, founds, n, outcome, err) &&
              verdict_race_whole(&t, outcome, err);
    outcome->trials = state->played + t.unlogged;
    outcome->launches = t.launches;
    outcome->seconds = (double)t.spent_ns * 1e-9;
    return ok;
}
