// SPDX-License-Identifier: MIT
// One tuning: what is measured next, until it is known how to share the work.
#ifndef TUNER_TUNE_H
#define TUNER_TUNE_H

#include "tuner/task.h"

// state is empty, or an interrupted tuning's. After INTERRUPTED it can be
// handed in again. Fills all of outcome but known, resumed and objects.
bool tune_run(const tune_task *task, trial_log *state, duet_tune_outcome *outcome, duet_error *err);

#endif
