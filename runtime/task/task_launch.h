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

// Makes the arrays and the kernels of the default variant, finds what is right if another kernel
// says it, and checks once that the kernel writes nothing outside its items. The task must live as
// long. BAD_INPUT if the file's arguments are not the card's, WRONG_RESULT for a kernel that writes
// elsewhere. NULL after a failure.
task_launcher *task_launcher_open(task *t, duet_device_pair *pair, duet_error *err);
void task_launcher_close(task_launcher *l); // NULL does nothing

// Launches the kernel on both devices by the plan's share and variants. Arrays have what the file
// says before each launch; what that takes does not count. WRONG_RESULT as task_check.
bool task_launch(task_launcher *l, const duet_plan *plan, task_result *result, duet_error *err);

// Launches it n times, of which only the last is checked.
bool task_launch_train(task_launcher *l, const duet_plan *plan, uint32_t n, duet_error *err);

// Reads the space of the kernel on a device by the plan, as kernel_spaces_read does.
bool task_kernel_space(task_launcher *l, const duet_plan *plan, int side, kernel_space **spaces,
                       uint32_t *n, duet_error *err);

// The hash of what the task's kernel is made from on the pair: its card, and its text.
bool task_kernel_hash(const task *t, const duet_device_pair *pair, char hash[65], duet_error *err);

#endif
