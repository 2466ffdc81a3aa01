// SPDX-License-Identifier: MIT
// Task files: a kernel of the user's, its arguments, and what is right.
#include "support/fuzz.h"

#include "runtime/task/task.h"

static void require_arg(const task *t, const task_arg *arg)
{
    fuzz_require(arg->kind != TASK_ARG_ARRAY || arg->initial.n == arg->count * arg->lanes);
    fuzz_require(arg->per_item == 0 || arg->per_item * t->items == arg->count);
    fuzz_require(!arg->expected.bytes || arg->expected.size == arg->initial.size);
}

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_file("fuzz.task.lua", data, n);
    duet_error err = {0};
    task *t = task_load(path.chars, NULL, 0, &err);
    fuzz_require_answer(t, &err);
    fuzz_require(!t || (t->n_args >= 1 && t->n_args <= GEN_MAX_ARGS && t->items > 0));
    for (uint32_t i = 0; t && i < t->n_args; ++i)
        require_arg(t, &t->args[i]);
    task_destroy(t);
}
