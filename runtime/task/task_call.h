// SPDX-License-Identifier: MIT
// The arguments of one kernel of a task, in the types of its card.
#ifndef RUNTIME_TASK_CALL_H
#define RUNTIME_TASK_CALL_H

#include "runtime/opencl/program.h"
#include "runtime/task/task.h"

enum { TASK_SLOTS = GEN_MAX_ARGS + 2 };

typedef union task_slot {
    cl_mem mem;
    cl_int i;
    cl_uint u;
    cl_long l;
    cl_ulong ul;
    cl_float f;
    cl_double d;
} task_slot;

// Slots in the order of the task's arguments, then `first` and `last`.
typedef struct task_call {
    char kernel[GEN_NAME];
    char entry[GEN_NAME];
    task_slot slots[TASK_SLOTS];
    task_scalar scalars[TASK_SLOTS];  // of numbers
    char types[TASK_SLOTS][24];       // as the card has them
    binding bindings[TASK_SLOTS + 1]; // names and types are the task's and the call's own
} task_call;

// Reads the kernel's card. BAD_INPUT names the file, and the argument that the card has otherwise.
// The call must stay where it is.
bool task_call_read(task_call *c, const task *t, const char *kernel_name, const char *entry, gen *g,
                    const gen_limits *limits, duet_error *err);

// Gives the next launch the argument's number. BAD_ARGUMENT if the kernel's type does not hold it.
bool task_call_set_number(task_call *c, const task *t, uint32_t arg, duet_error *err);

// The items of the next launch.
void task_call_aim(task_call *c, const task *t, uint64_t first, uint64_t last);

#endif
