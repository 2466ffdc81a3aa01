// SPDX-License-Identifier: MIT
// A task as a Lua table, of a file's or made of a def in C, so that both mean and refuse the same.
#ifndef RUNTIME_TASK_READ_H
#define RUNTIME_TASK_READ_H

#include "runtime/task/task.h"

#include <lua.h>

typedef enum task_use {
    TASK_CHECKED,
    TASK_UNCHECKED // what is right is not read
} task_use;

typedef struct task_reading {
    task *task; // filled
    const duet_setting *settings;
    uint32_t n_settings;
    bool declared; // the script has declared its parameters
    uint64_t seed; // the parameter of that name; 0: there is none
    task_use use;
    duet_error why;
} task_reading;

// table, reading ->
int task_read_table(lua_State *L);

#endif
