// SPDX-License-Identifier: MIT
// An application's task: a task file on a device pair, with the plan of its runs.
#ifndef RUNTIME_APP_TASK_H
#define RUNTIME_APP_TASK_H

#include "runtime/task/task_launch.h"

struct duet_task {
    task *file;
    task_launcher *launcher;
    duet_device_pair *pair; // the launcher holds it
    duet_plan plan;         // no default is left in it
    duet_task_arg args[GEN_MAX_ARGS];
    task_result result; // of the last run
};

#endif
