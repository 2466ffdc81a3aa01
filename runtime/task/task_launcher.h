// SPDX-License-Identifier: MIT
// What a launcher holds: a task's arrays on each device, or in buffers of the caller's.
#ifndef RUNTIME_TASK_LAUNCHER_H
#define RUNTIME_TASK_LAUNCHER_H

#include "runtime/opencl/callers_buffer.h"
#include "runtime/opencl/shared_work.h"
#include "runtime/task/task_call.h"
#include "runtime/task/task_launch.h"

// How a device comes by an array.
typedef enum task_way {
    TASK_SENT_EACH, // it is sent in each launch
    TASK_SENT,      // it is sent once, and was
    TASK_IN_PLACE   // it lies in a buffer of the caller's that the device works on
} task_way;

typedef struct task_side {
    work_side side; // the first member: shared work hands it on
    struct task_launcher *launcher;
    task_call own;       // the task's kernel
    task_call reference; // the kernel that finds what is right, if one does
    task_call *call;     // of the next launch
    const kernel *kernel;
    char variant[DUET_VARIANT];        // that kernel is of; empty: none is made
    buffer buffers[GEN_MAX_ARGS];      // the arrays, each all of it
    task_way ways[GEN_MAX_ARGS];       // of the arrays
    task_values partial[GEN_MAX_ARGS]; // a device's sum
    double guarded_ms;                 // that its kernel took between guards
} task_side;

// A buffer of the caller's that an array lies in.
typedef struct task_bound {
    cl_mem mem;            // NULL: it lies in memory of ours
    const device *device;  // by whose queue the host reads and writes it
    callers_events events; // what the next launch waits for
} task_bound;

struct task_launcher {
    task *task;
    shared_work work;
    task_side sides[2];
    task_values results[GEN_MAX_ARGS]; // what a launch wrote, and writes go on from
    task_bound bound[GEN_MAX_ARGS];
    double estimate_ms; // about how long all of the work takes; 0: not known
};

// The host's copy of an array: what a launch sends, or has written.
task_values *task_host_values(task_launcher *l, uint32_t arg);

// The bytes of an array that belong to items [first, last), or all of it.
void task_arg_range(const task_arg *arg, uint64_t items, uint64_t first, uint64_t last,
                    size_t *from, size_t *to);

// Sends what the side's items need, and what is read by all.
bool task_side_send(task_side *s, duet_error *err);
bool task_side_launch(task_side *s, duet_error *err);

// Gives the kernel the argument's number in the following launches. BAD_ARGUMENT if its type does
// not hold it.
bool task_set_number(task_launcher *l, uint32_t arg, duet_error *err);

// Binds an array to a buffer of the caller's; call and argument are for messages.
bool task_bind(task_launcher *l, uint32_t arg, cl_mem mem, cl_uint n_events, const cl_event *events,
               const char *call, duet_error *err);
void task_unbind(task_launcher *l, uint32_t arg); // one that is not bound is passed over

// Brings what lies in the caller's buffers to the host where a device needs it that does not work
// on the buffer; the sides' items must be known. Afterwards the other way round.
bool task_bound_load(task_launcher *l, duet_error *err);
bool task_bound_store(task_launcher *l, duet_error *err);

// Brings all of an array to the host's copy.
bool task_bound_see(task_launcher *l, uint32_t arg, duet_error *err);

// Checks that the kernel writes nothing outside its items, at this share.
bool task_guard_check(task_launcher *l, uint32_t share, duet_error *err);

#endif
