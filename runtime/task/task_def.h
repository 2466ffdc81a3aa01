// SPDX-License-Identifier: MIT
// A task that an application describes in C.
#ifndef RUNTIME_TASK_DEF_H
#define RUNTIME_TASK_DEF_H

#include "runtime/task/task_read.h"

// Copies what the def says in the place of a file; call: for messages. BAD_ARGUMENT names the
// kernel and the member. NULL after a failure.
task *task_make(const duet_task_def *def, task_use use, const char *call, duet_error *err);

#endif
