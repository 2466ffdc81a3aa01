// SPDX-License-Identifier: MIT
// What a launcher holds: a task's arrays on each device.
#ifndef RUNTIME_TASK_LAUNCHER_H
#define RUNTIME_TASK_LAUNCHER_H

#include "runtime/opencl/shared_work.h"
#include "runtime/task/task_call.h"
#include "runtime/task/task_launch.h"

typedef struct task_side {
    work_side side; // the first member: shared work hands it on
    struct task_launcher *launcher;
    task_call own;       // the task's kernel
    task_call reference; // the kernel that finds what is right, if one does
    task_call *call;     // of the next launch
    const kernel *kernel;
    char variant[DUET_VARIANT];        // that kernel is of; empty: none is made
    buffer buffers[GEN_MAX_ARGS];      // the arrays, each all of it
    bool sent[GEN_MAX_ARGS];           // it is sent once, and was
    task_values partial[GEN_MAX_ARGS]; // a device's sum
} task_side;

struct task_launcher {
    task *task;
    shared_work work;
    task_side sides[2];
    task_values results[GEN_MAX_ARGS]; // what a launch wrote
};

// Bytes of an array, from the item's first element on.
size_t task_arg_offset(const task_arg *arg, uint64_t item);

// The bytes of an array that belong to items [first, last), or all of it.
void task_arg_range(const task_arg *arg, uint64_t items, uint64_t first, uint64_t last,
                    size_t *from, size_t *to);

// Sends what the side's items need, and what is read by all.
bool task_side_send(task_side *s, duet_error *err);
bool task_side_launch(task_side *s, duet_error *err);

// Checks that the kernel writes nothing outside its items, at this share.
bool task_guard_check(task_launcher *l, uint32_t share, duet_error *err);

#endif
