// SPDX-License-Identifier: MIT
// Tasks: an OpenCL kernel of the caller's with its arguments, whose items two devices share.
//
// A task file says what the arguments are, how many items there are, and what is right; beside it
// lie the kernel's text and its card (docs/tasks.md). An application ships the three with a store
// of profiles, or says in C what a task file would: it creates a task, loads the plan that was
// measured for it, and in each frame sets arguments, runs, and reads what the kernel wrote.
#ifndef DUET_TASK_H
#define DUET_TASK_H

#include "duet_world.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// ---------------------------------------------------------------- what a task is

// An argument of a task that has no file. A task file would leave out what is zero or NULL.
typedef struct duet_task_arg_def {
    const char *name;     // the card's
    double number;        // unless it is an array; duet_task_set_integer sets those of 64 bits
    const char *type;     // an array's element, "float4"; NULL: it is a number
    uint64_t elements;    // number of them in an array
    const char *access;   // to an array, as in duet_task_arg; NULL: "all"
    uint64_t halo;        // items before and behind a "slice" that are read too
    const char *send;     // "once": an array that is read stays on the devices; NULL: "each"
    const void *initial;  // [elements] before a run, of an array that is read; NULL: zeros
    const void *expected; // [elements] behind one, of an array that is written; NULL: the
                          // reference finds it
} duet_task_arg_def;

// A kernel that a program carries: what else lies in NAME.lua and NAME.cl.
typedef struct duet_kernel_text {
    const char *name;
    const char *card; // Lua, as docs/generation.md has it
    const char *text; // OpenCL C
} duet_kernel_text;

// A task: a file, or else what a file would say. All is copied by the call that takes it.
typedef struct duet_task_def {
    duet_device_pair *pair;       // held until the task is destroyed
    duet_plan plan;               // only share and variants count: a task has no modes
    const char *path;             // task file; NULL: the members behind n_settings say it
    const duet_setting *settings; // [n_settings] of the file's parameters
    uint32_t n_settings;

    const char *folder; // with the kernel's card and text, unless the pair has a kernel_dir
    const char *kernel; // the name of its card
    const duet_kernel_text *kernels; // [n_kernels] that are in no folder
    uint32_t n_kernels;
    const char *entry;             // the kernel function in it; NULL: of the same name
    const duet_task_arg_def *args; // [n_args] in any order, all but `first` and `last`
    uint32_t n_args;
    uint64_t items;
    uint64_t work;           // work-units of an item; 0: 1
    uint64_t high;           // rows of so many units each; 0: one
    const char *reference;   // the kernel that finds what is right; NULL: this one on device B
    double tolerance;        // part of the greater of 1 and what is expected; 0: exact
    const duet_setting *key; // [n_key] words that tell it from others of its kernel, as "bins";
    uint32_t n_key;          // "n" is the size by which plans of other sizes are found: NULL: items
    int cookie;
} duet_task_def;

DUET_API duet_task_def duet_default_task_def(void);

// A task with what is right: duet_tune_run tunes it.
typedef struct duet_task_file duet_task_file;

// Reads a task file with these settings of its parameters. NOT_FOUND names the path, BAD_INPUT the
// file and the field, BAD_ARGUMENT a parameter that the file does not declare.
DUET_API duet_task_file *duet_task_file_load(const char *path, const duet_setting *settings,
                                             uint32_t n_settings, duet_error *err);

// Makes the same of a def, of which pair and plan do not count: a task that an application has in C
// alone is tuned, and each launch checked. BAD_ARGUMENT names the kernel and the member.
DUET_API duet_task_file *duet_task_file_create(const duet_task_def *def, duet_error *err);
DUET_API void duet_task_file_destroy(duet_task_file *file);

// ---------------------------------------------------------------- tasks

// A task on a device pair, run again and again. A task belongs to one thread at a time.
typedef struct duet_task duet_task;

// Creates a task: makes its arrays on both devices, and builds its kernels. Card and text of the
// kernel are in the pair's kernel_dir, or else in the folder of the task file, or the def's. Arrays
// hold what file or def gives them. What is right is not read, and no launch is checked:
// duet_tune_run and 'duet run --task' check. Errors as of duet_task_file_load and _create;
// BAD_INPUT also names a kernel that is not there, or an argument that the card has otherwise,
// BUILD_FAILED the kernel and the compiler's first line.
DUET_API duet_task *duet_task_create(const duet_task_def *def, duet_error *err);
DUET_API void duet_task_destroy(duet_task *task);

// An argument of a task's kernel.
typedef struct duet_task_arg {
    const char *name;   // the task's
    const char *type;   // type of an element of an array, "float4"; "" for a number
    const char *access; // access to an array: "all", "slice", "out slice", "in out slice" or "sum"
    uint64_t elements;  // number of them in an array; 0: it is a number
    uint32_t bytes;     // size of an element
} duet_task_arg;

// Returns argument i, by name; NULL past the last and for NULL. It lasts as long as the task.
DUET_API const duet_task_arg *duet_task_get_arg(const duet_task *task, uint32_t i);
DUET_API uint64_t duet_task_get_items(const duet_task *task); // 0 for NULL

// ---------------------------------------------------------------- arguments

// Sets a number for the following runs. BAD_ARGUMENT if the task has no such number, or if the
// kernel's type does not hold the value: the line names both.
DUET_API bool duet_task_set_number(duet_task *task, const char *name, double value,
                                   duet_error *err);
DUET_API bool duet_task_set_integer(duet_task *task, const char *name, int64_t value,
                                    duet_error *err);

// Copies n elements into an array that the kernel reads: all that it has. BAD_ARGUMENT for another
// n, or for an array that is only written. An "in out slice" goes on from what the last run left
// until it is set again.
DUET_API bool duet_task_set_array(duet_task *task, const char *name, const void *elements,
                                  uint64_t n, duet_error *err);

// Returns the elements of an array on the host and sets *n, which may be NULL, to their number:
// what the last run wrote, or what was set. Arrays that are only written hold zeros before the
// first run. Valid until the task is set, run or destroyed.
DUET_API const void *duet_task_get_array(duet_task *task, const char *name, uint64_t *n,
                                         duet_error *err);

// ---------------------------------------------------------------- plans

// Sets the plan of the following runs and builds the kernels of its variants. If the pair is one
// device, that does all. After a failure the plan is as before.
DUET_API bool duet_task_set_plan(duet_task *task, const duet_plan *plan, duet_error *err);
DUET_API const duet_plan *duet_task_get_plan(const duet_task *task); // NULL for NULL

// Gives the task the best plan that is known for its kernel, key and size on its devices, from a
// store as in duet_world_load_profile: path NULL is the user's and the system's; if nothing is
// known, or the kernel's text changed since, the plan stays as it is. profile->plan is the plan
// after the call. After a failure (a store that cannot be read) an application may go on.
DUET_API bool duet_task_load_profile(duet_task *task, const char *path, duet_profile *profile,
                                     duet_error *err);

// ---------------------------------------------------------------- runs

// Times of a run. Its memory is the task's and lasts until the next run.
typedef struct duet_task_result {
    double total_ms;     // wall clock, arguments in to what was written on the host
    double device_ms[2]; // wall clock of each device's part; 0: it had no item
    const duet_stage *stages;
    uint32_t n_stages;
} duet_task_result;

// Runs the kernel over all items: device A does the share's part from item 0 on, and B the rest.
// After a failure the arrays that the kernel writes are undefined, and the task can be run again.
DUET_API bool duet_task_run(duet_task *task, duet_task_result *result, duet_error *err);

DUET_C_END

#endif
