// SPDX-License-Identifier: MIT
// A task on a device pair: launched by plans, each launch checked.
#ifndef RUNTIME_TASK_LAUNCH_H
#define RUNTIME_TASK_LAUNCH_H

#include "runtime/broadphase/kernel_space.h"
#include "runtime/task/task.h"

enum { TASK_STAGES = 16 };

// The task's arrays on both devices, and its kernels there.
typedef struct task_launcher task_launcher;

// Times of a launch: what is sent, the kernels, what is fetched and merged.
typedef struct task_result {
    double total_ms;
    double device_ms[2]; // 0: the device had no item
    duet_stage stages[TASK_STAGES];
    uint32_t n_stages;
} task_result;

// Makes the arrays and the kernels of the default variant. The task must live as long. BAD_INPUT if
// the file's arguments are not the card's. NULL after a failure.
task_launcher *task_launcher_open_unchecked(task *t, duet_device_pair *pair, duet_error *err);

// The same; also finds what is right if another kernel says it, and checks once that the kernel
// writes nothing outside its items. WRONG_RESULT for a kernel that writes elsewhere.
task_launcher *task_launcher_open(task *t, duet_device_pair *pair, duet_error *err);
void task_launcher_close(task_launcher *l); // NULL does nothing

// Launches the kernel on both devices by the plan's share and variants. Arrays have what the file
// says before each launch; what that takes does not count. WRONG_RESULT as task_check_bytes.
bool task_launch(task_launcher *l, const duet_plan *plan, task_result *result, duet_error *err);

// From now on a launch does only that part, of DUET_SHARE_ONE, of each device's items, the first
// ones, and what is reset and checked is theirs.
void task_launcher_set_part(task_launcher *l, uint32_t part);

// About how long all of the work takes both devices; 0: a part of it cannot be checked.
double task_launcher_estimate_ms(const task_launcher *l);

// The parts of task_launch before and behind the launch.
void task_launch_reset(task_launcher *l, const duet_plan *plan);
bool task_launch_check(task_launcher *l, duet_error *err);

// The same with arrays as they are, and unchecked. An array that is read and written goes on from
// what the last launch left.
bool task_launch_unchecked(task_launcher *l, const duet_plan *plan, task_result *result,
                           duet_error *err);

// Makes the kernels of the plan's variants, unless they are there.
bool task_launcher_prepare(task_launcher *l, const duet_plan *plan, duet_error *err);

// Launches it n times, of which only the last is checked.
bool task_launch_train(task_launcher *l, const duet_plan *plan, uint32_t n, duet_error *err);

// Adds the space of the kernel on a device by the plan, as kernel_spaces_read does.
bool task_kernel_space(task_launcher *l, const duet_plan *plan, int side, kernel_spaces *to,
                       duet_error *err);

#endif
