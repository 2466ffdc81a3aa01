// SPDX-License-Identifier: MIT
// A task launched again and again, with the times of each launch, all of them checked.
#ifndef CLI_TIMED_TASK_H
#define CLI_TIMED_TASK_H

#include "cli/timed.h"
#include "runtime/task/task_launch.h"

// Runs it as timed_run does: once to warm up, and then repeat times. It has no pairs and no hash.
bool timed_task_run(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                    uint32_t repeat, duet_error *err);

#endif
