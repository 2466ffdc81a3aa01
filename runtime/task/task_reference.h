// SPDX-License-Identifier: MIT
// What a task's arrays must hold after a launch, as its file says it: a Lua function, a file of
// numbers, or another kernel.
#ifndef RUNTIME_TASK_REFERENCE_H
#define RUNTIME_TASK_REFERENCE_H

#include "runtime/task/task.h"

#include <lua.h>

// Reads the field `reference` of the table at index `root`: fills what the written arrays are
// expected to hold, or the name of the kernel that finds it. Raises Lua errors.
void task_reference_read(lua_State *L, int root, task *t, duet_error *why);

// Makes the written arrays' expected values: what they hold before a launch.
bool task_expect_initial(task *t, duet_error *err);

// Puts the Lua value at index into the array; false unless it is a number that the scalar holds.
bool task_values_put(task_values *v, uint64_t i, lua_State *L, int index);

#endif
