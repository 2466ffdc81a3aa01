// SPDX-License-Identifier: MIT
// A task: a kernel of the user's, with its arguments, whose items two devices share.
//
// A task file is Lua. It names the kernel, gives each argument a value or an array, and says how
// many items there are, what is right, and how near to that is near enough. Device A does items
// [0, k) and B the rest; each array says how it goes with that (task_access).
#ifndef RUNTIME_TASK_H
#define RUNTIME_TASK_H

#include "gen/gen.h"
#include "runtime/duet.h"

enum { TASK_NAME = 64, TASK_KEY = 160, TASK_WORDS = GEN_NAME + TASK_KEY + 8 };

// How an array goes with the items.
typedef enum task_access {
    TASK_ALL,    // read by both, all of it
    TASK_SLICE,  // read, each device the elements of its items and `halo` items beside them
    TASK_OUT,    // written, each device the elements of its items
    TASK_IN_OUT, // read and written, likewise
    TASK_SUM     // both add to all of it from 0, and their sums are added
} task_access;

const char *task_access_name(task_access access);

typedef enum task_scalar {
    TASK_CHAR,
    TASK_UCHAR,
    TASK_SHORT,
    TASK_USHORT,
    TASK_INT,
    TASK_UINT,
    TASK_LONG,
    TASK_ULONG,
    TASK_FLOAT,
    TASK_DOUBLE,
    TASK_SCALARS
} task_scalar;

// Components of one kind, one behind the other.
typedef struct task_values {
    task_scalar scalar;
    uint64_t n;
    void *bytes; // NULL: there are none
    size_t size;
} task_values;

// Returns the scalar of that name and its lanes, of "float4"; false if there is none.
bool task_type_read(const char *name, task_scalar *scalar, uint32_t *lanes);
size_t task_scalar_bytes(task_scalar scalar);
bool task_scalar_is_whole(task_scalar scalar); // an integer

bool task_values_make(task_values *v, task_scalar scalar, uint64_t n, duet_error *err); // zeros
void task_values_free(task_values *v);
double task_values_get(const task_values *v, uint64_t i);
int64_t task_values_get_whole(const task_values *v, uint64_t i); // of whole scalars
void task_values_set(task_values *v, uint64_t i, double value);
void task_values_set_whole(task_values *v, uint64_t i, int64_t value);

// A number keeps in `value` what it is, and in `whole` too if it was written as an integer.
typedef enum task_arg_kind { TASK_ARG_REAL, TASK_ARG_WHOLE, TASK_ARG_ARRAY } task_arg_kind;

typedef struct task_arg {
    char name[GEN_NAME];
    task_arg_kind kind;
    double value;
    int64_t whole;
    char type[24];     // of an element, "float4"; this and the rest of an array
    uint32_t lanes;    // components of an element
    uint64_t count;    // elements
    uint64_t per_item; // elements of an item; 0: the array does not go with items
    uint64_t halo;     // items beside a slice
    task_access access;
    bool once;            // sent before the first launch only
    task_values initial;  // what it holds before a launch
    task_values expected; // what it must hold after one; none: it is not written, or task.reference
                          // says so
} task_arg;

// A kernel that lies in no folder.
typedef struct task_kernel {
    char *name, *card, *text;
} task_kernel;

typedef struct duet_task_file {
    char name[TASK_NAME]; // the file's, without folder and endings
    char *path;           // the file's
    char *folder;         // the file's, where its kernel is by default; NULL: there is none
    task_kernel *kernels; // [n_kernels] that the task brings with it
    uint32_t n_kernels;
    char kernel[GEN_NAME];
    char entry[GEN_NAME];     // of the kernel
    char reference[GEN_NAME]; // a kernel that finds what is right; empty: the arrays expect it
    int kernel_line;          // of the file, that names it; 0: not known
    int reference_line;
    char key[TASK_KEY];          // what tells the task from others of its kernel: "bins=64"
    task_arg args[GEN_MAX_ARGS]; // by name
    uint32_t n_args;
    uint64_t items;
    uint64_t size;        // key.n, or items
    uint64_t work;        // work-units of an item
    uint64_t wide;        // of these side by side, the others above each other
    char checked_on[256]; // the device B of whose tuning what is right was found, and guards were
                          // set
    double tolerance;     // by the greater of 1 and the expected value; 0: exact
} task;

// Reads the file with these parameters set. BAD_INPUT names file and field, BAD_ARGUMENT a
// parameter that cannot be set. NULL after a failure.
task *task_load(const char *path, const duet_setting *settings, uint32_t n_settings,
                duet_error *err);

// The same without what is right: such a task cannot be checked.
task *task_load_unchecked(const char *path, const duet_setting *settings, uint32_t n_settings,
                          duet_error *err);
void task_destroy(task *t); // NULL does nothing

// The folder of the kernel's text and card on that pair.
const char *task_kernel_dir(const task *t, const duet_device_pair *pair);

// Adds the kernels that the task brings with it. BAD_INPUT if there is none that it names.
bool task_add_kernels(const task *t, gen *g, duet_error *err);

// Returns the index of the argument of that name; n_args if there is none.
uint32_t task_find_arg(const task *t, const char *name);

// "task saxpy bins=64": by which the profile store knows it.
void task_write_words(const task *t, char words[TASK_WORDS]);

// The hash of what the task's kernel is made from on the pair: its card, and its text.
bool task_kernel_hash(const task *t, const duet_device_pair *pair, char hash[65], duet_error *err);

// Whether a launch changes the array.
bool task_arg_is_written(const task_arg *arg);

// Compares bytes [from, to) of the array with what is expected. WRONG_RESULT names the first item
// that is wrong, both values and the bound.
bool task_check_bytes(const task *t, const task_arg *arg, const task_values *found, size_t from,
                      size_t to, duet_error *err);

#endif
