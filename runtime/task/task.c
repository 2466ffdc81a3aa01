// SPDX-License-Identifier: MIT
#include "runtime/task/task.h"

#include "base/error.h"
#include "base/text.h"
#include "runtime/opencl/device_pair.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *task_access_name(task_access access)
{
    static const char *const names[] = {"all", "slice", "out slice", "in out slice", "sum"};
    return access <= TASK_SUM ? names[access] : NULL;
}

uint32_t task_find_arg(const task *t, const char *name)
{
    uint32_t i = 0;
    while (i < t->n_args && strcmp(t->args[i].name, name) != 0)
        ++i;
    return i;
}

const char *task_kernel_dir(const task *t, const duet_device_pair *pair)
{
    return pair->kernel_dir ? pair->kernel_dir : t->folder;
}

static bool check_name(const task *t, const gen *g, const char *field, int line, const char *name,
                       duet_error *err)
{
    text all = {0};
    uint32_t i = 0;
    char at[16] = "";
    for (; gen_kernel(g, i) && strcmp(gen_kernel(g, i), name) != 0; ++i)
        text_add(&all, "%s%s", i > 0 ? ", " : "", gen_kernel(g, i));
    if (line > 0)
        snprintf(at, sizeof at, ":%d", line);
    bool ok =
        gen_kernel(g, i) || bad_input(err, "%s%s: %s is '%s'; expected a kernel: there are %s",
                                      t->path, at, field, name, i > 0 ? text_chars(&all) : "none");
    text_free(&all);
    return ok;
}

bool task_add_kernels(const task *t, gen *g, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < t->n_kernels; ++i)
        ok = gen_add(g, t->kernels[i].name, t->kernels[i].card, t->kernels[i].text, err);
    return ok && check_name(t, g, "kernel", t->kernel_line, t->kernel, err) &&
           (!*t->reference || check_name(t, g, "reference", t->reference_line, t->reference, err));
}

static void free_kernels(task *t)
{
    for (uint32_t i = 0; i < t->n_kernels; ++i) {
        free(t->kernels[i].name);
        free(t->kernels[i].card);
        free(t->kernels[i].text);
    }
    free(t->kernels);
}

void task_destroy(task *t)
{
    if (!t)
        return;
    free_kernels(t);
    for (uint32_t i = 0; i < t->n_args; ++i) {
        task_values_free(&t->args[i].initial);
        task_values_free(&t->args[i].expected);
    }
    free(t->path);
    free(t->folder);
    free(t);
}

void task_write_words(const task *t, char words[TASK_WORDS])
{
    snprintf(words, TASK_WORDS, "task %s%s%s", t->kernel, *t->key ? " " : "", t->key);
}

bool task_arg_is_written(const task_arg *arg)
{
    return arg->kind == TASK_ARG_ARRAY && arg->access >= TASK_OUT;
}

// ---------------------------------------------------------------- what is right

// A number as messages show it: whole ones as they are.
typedef struct shown {
    char chars[32];
} shown;

static shown show(const task_values *v, uint64_t i)
{
    shown s;
    if (v->scalar == TASK_ULONG)
        snprintf(s.chars, sizeof s.chars, "%" PRIu64, (uint64_t)task_values_get_whole(v, i));
    else if (task_scalar_is_whole(v->scalar))
        snprintf(s.chars, sizeof s.chars, "%" PRId64, task_values_get_whole(v, i));
    else
        snprintf(s.chars, sizeof s.chars, "%.*g", v->scalar == TASK_FLOAT ? 9 : 17,
                 task_values_get(v, i));
    return s;
}

static double bound_of(const task *t, double expected)
{
    return t->tolerance * fmax(1, fabs(expected));
}

// Infinite numbers, and numbers that are none, are right where they are expected.
static bool is_near(const task *t, const task_values *found, const task_values *expected,
                    uint64_t i)
{
    double a = task_values_get(found, i), b = task_values_get(expected, i);
    double off = fabs(a - b);
    return a == b || (isnan(a) && isnan(b)) || (off <= bound_of(t, b) && off < INFINITY);
}

static bool is_same(const task_values *found, const task_values *expected, uint64_t i)
{
    size_t bytes = task_scalar_bytes(found->scalar);
    return memcmp((const char *)found->bytes + i * bytes, (const char *)expected->bytes + i * bytes,
                  bytes) == 0;
}

static bool tell_wrong(const task *t, const task_arg *arg, const task_values *found, uint64_t i,
                       duet_error *err)
{
    char item[32] = "", component[16] = "", bound[48] = "";
    uint64_t element = i / arg->lanes;
    if (arg->per_item > 0)
        snprintf(item, sizeof item, "item %" PRIu64 ": ", element / arg->per_item);
    if (arg->lanes > 1)
        snprintf(component, sizeof component, ".s%x", (unsigned)(i % arg->lanes));
    if (t->tolerance > 0)
        snprintf(bound, sizeof bound, " within %.3g",
                 bound_of(t, task_values_get(&arg->expected, i)));
    return error_set(err, DUET_STATUS_WRONG_RESULT,
                     "task %s: %s%s[%" PRIu64 "]%s is %s; expected %s%s", t->name, item, arg->name,
                     element, component, show(found, i).chars, show(&arg->expected, i).chars,
                     bound);
}

// A quick look without a way out of its loop, for most numbers of most kernels: false also for
// infinite numbers, and for numbers that are none.
static bool floats_are_near(const float *found, const float *expected, uint64_t n, double tolerance)
{
    bool near = true;
    for (uint64_t i = 0; i < n; ++i) {
        double size = fabs((double)expected[i]), off = fabs((double)found[i] - (double)expected[i]);
        near &= (off <= tolerance * (size > 1 ? size : 1)) & (off < INFINITY);
    }
    return near;
}

// Returns the first wrong number of [from, to); `to` if there is none.
static uint64_t find_wrong(const task *t, const task_values *found, const task_values *expected,
                           uint64_t from, uint64_t to)
{
    if (found->scalar == TASK_FLOAT && t->tolerance > 0 &&
        floats_are_near((const float *)found->bytes + from, (const float *)expected->bytes + from,
                        to - from, t->tolerance))
        return to;
    while (from < to &&
           (t->tolerance > 0 ? is_near(t, found, expected, from) : is_same(found, expected, from)))
        ++from;
    return from;
}

bool task_check_bytes(const task *t, const task_arg *arg, const task_values *found, size_t from,
                      size_t to, duet_error *err)
{
    enum { BLOCK = 1024 };
    const task_values *expected = &arg->expected;
    const size_t bytes = task_scalar_bytes(found->scalar);
    if (memcmp((char *)found->bytes + from, (char *)expected->bytes + from, to - from) == 0)
        return true;
    for (uint64_t i = from / bytes, next; i < to / bytes; i = next) {
        next = to / bytes - i > BLOCK ? i + BLOCK : to / bytes;
        uint64_t wrong = find_wrong(t, found, expected, i, next);
        if (wrong < next)
            return tell_wrong(t, arg, found, wrong, err);
    }
    return true;
}
