// SPDX-License-Identifier: MIT
// The arguments of a task's kernel, as its file gives them: numbers and arrays.
#ifndef RUNTIME_TASK_ARGS_H
#define RUNTIME_TASK_ARGS_H

#include "runtime/task/task.h"

#include <lua.h>

// Items, elements and work-units stay below it, so that their products fit.
#define TASK_MOST (INT64_C(1) << 40)

// Reads the field `args` of the table at index `root`, once the task's items are known. seed: of
// random numbers. Raises Lua errors.
void task_args_read(lua_State *L, int root, task *t, uint64_t seed, duet_error *why);

#endif
