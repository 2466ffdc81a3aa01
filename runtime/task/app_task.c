// SPDX-License-Identifier: MIT
#include "runtime/task/app_task.h"

#include "base/error.h"
#include "runtime/duet_opencl.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/task/task_def.h"
#include "runtime/task/task_launcher.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7a5c };

// ---------------------------------------------------------------- task files

static bool check_settings(const duet_setting *settings, uint32_t n, const char *call,
                           duet_error *err)
{
    bool ok = n == 0 || error_given(settings, call, "settings", err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = error_given(settings[i].name, call, "the name of a setting", err) &&
             error_given(settings[i].value, call, "the value of a setting", err);
    return ok;
}

duet_task_file *duet_task_file_load(const char *path, const duet_setting *settings,
                                    uint32_t n_settings, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(path, __func__, "path", err) ||
        !check_settings(settings, n_settings, __func__, err))
        return NULL;
    return task_load(path, settings, n_settings, err);
}

static bool check_cookie(const duet_task_def *def, duet_error *err)
{
    return error_def(def && def->cookie == COOKIE, "task", "duet_default_task_def", err);
}

static task *describe(const duet_task_def *def, task_use use, const char *call, duet_error *err)
{
    if (!def->path)
        return task_make(def, use, call, err);
    if (!check_settings(def->settings, def->n_settings, call, err))
        return NULL;
    return use == TASK_CHECKED
               ? task_load(def->path, def->settings, def->n_settings, err)
               : task_load_unchecked(def->path, def->settings, def->n_settings, err);
}

duet_task_file *duet_task_file_create(const duet_task_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    return check_cookie(def, err) ? describe(def, TASK_CHECKED, __func__, err) : NULL;
}

void duet_task_file_destroy(duet_task_file *file)
{
    task_destroy(file);
}

// ---------------------------------------------------------------- plans

static bool check_ends(const char *name, const char *chars, duet_error *err)
{
    return memchr(chars, '\0', DUET_VARIANT) ||
           bad_argument(err, "%s has no end within its %d bytes", name, DUET_VARIANT);
}

// Fills in what the plan leaves open. A task has no modes.
static bool resolve_plan(const duet_plan *given, const duet_device_pair *pair, duet_plan *plan,
                         duet_error *err)
{
    *plan = *given;
    plan->mode = DUET_MODE_OWN;
    if (plan->share == DUET_SHARE_DEFAULT)
        plan->share = duet_default_plan(pair).share;
    if (!check_ends("variant_a", plan->variant_a, err) ||
        !check_ends("variant_b", plan->variant_b, err))
        return false;
    char *variants[2] = {plan->variant_a, plan->variant_b};
    for (int side = 0; side < 2; ++side)
        if (!*variants[side])
            strcpy(variants[side], "auto");
    return shared_work_check(plan->share, err);
}

bool duet_task_set_plan(duet_task *t, const duet_plan *plan, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_plan whole;
    if (!error_given(t, __func__, "task", err) || !error_given(plan, __func__, "plan", err) ||
        !resolve_plan(plan, t->pair, &whole, err) ||
        !task_launcher_prepare(t->launcher, &whole, err))
        return false;
    t->plan = whole;
    return true;
}

const duet_plan *duet_task_get_plan(const duet_task *t)
{
    return t ? &t->plan : NULL;
}

// ---------------------------------------------------------------- owner

duet_task_def duet_default_task_def(void)
{
    return (duet_task_def){.plan = duet_default_plan(NULL), .cookie = COOKIE};
}

static void list_args(duet_task *t)
{
    for (uint32_t i = 0; i < t->file->n_args; ++i) {
        const task_arg *arg = &t->file->args[i];
        t->args[i] = (duet_task_arg){.name = arg->name, .type = arg->type, .access = ""};
        if (arg->kind != TASK_ARG_ARRAY)
            continue;
        t->args[i].access = task_access_name(arg->access);
        t->args[i].elements = arg->count;
        t->args[i].bytes = (uint32_t)(arg->initial.size / arg->count);
    }
}

static bool open(duet_task *t, const duet_task_def *def, const char *call, duet_error *err)
{
    t->pair = def->pair;
    t->file = describe(def, TASK_UNCHECKED, call, err);
    if (!t->file || !resolve_plan(&def->plan, t->pair, &t->plan, err))
        return false;
    list_args(t);
    t->launcher = task_launcher_open_unchecked(t->file, t->pair, err);
    return t->launcher && task_launcher_prepare(t->launcher, &t->plan, err);
}

duet_task *duet_task_create(const duet_task_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!check_cookie(def, err) || !error_given(def->pair, __func__, "the def's pair", err))
        return NULL;
    duet_task *t = calloc(1, sizeof *t);
    if (!t)
        return null_no_memory(err, "a task");
    if (open(t, def, __func__, err))
        return t;
    duet_task_destroy(t);
    return NULL;
}

void duet_task_destroy(duet_task *t)
{
    if (!t)
        return;
    task_launcher_close(t->launcher);
    task_destroy(t->file);
    free(t);
}

const duet_task_arg *duet_task_get_arg(const duet_task *t, uint32_t i)
{
    return t && i < t->file->n_args ? &t->args[i] : NULL;
}

uint64_t duet_task_get_items(const duet_task *t)
{
    return t ? t->file->items : 0;
}

// ---------------------------------------------------------------- arguments

// "x is an array" or "x is a number": which the call expected otherwise.
static bool find_arg(const duet_task *t, const char *name, bool is_array, const char *call,
                     uint32_t *i, duet_error *err)
{
    if (!error_given(t, call, "task", err) || !error_given(name, call, "name", err))
        return false;
    const task *file = t->file;
    *i = task_find_arg(file, name);
    if (*i == file->n_args)
        return bad_argument(err, "%s: %.48s is no argument of task %s; expected one as %s", call,
                            name, file->name, file->args[0].name);
    return (file->args[*i].kind == TASK_ARG_ARRAY) == is_array ||
           bad_argument(err, "%s: %s is a%s; expected a%s", call, name,
                        is_array ? " number" : "n array", is_array ? "n array" : " number");
}

// After a failure the number is as before.
static bool set_number(duet_task *t, const char *name, const task_arg *value, const char *call,
                       duet_error *err)
{
    uint32_t i;
    if (!find_arg(t, name, false, call, &i, err))
        return false;
    task_arg *arg = &t->file->args[i];
    const task_arg before = *arg;
    arg->value = value->value;
    arg->whole = value->whole;
    arg->kind = value->kind;
    bool ok = task_set_number(t->launcher, i, err);
    if (ok)
        return true;
    *arg = before;
    return task_set_number(t->launcher, i, NULL) && ok;
}

bool duet_task_set_number(duet_task *t, const char *name, double value, duet_error *err)
{
    PUBLIC_CALL(err);
    task_arg number = {.value = value};
    if (value == floor(value) && fabs(value) < 0x1p63) {
        number.kind = TASK_ARG_WHOLE;
        number.whole = (int64_t)value;
    }
    return set_number(t, name, &number, __func__, err);
}

bool duet_task_set_integer(duet_task *t, const char *name, int64_t value, duet_error *err)
{
    PUBLIC_CALL(err);
    const task_arg number = {.value = (double)value, .whole = value, .kind = TASK_ARG_WHOLE};
    return set_number(t, name, &number, __func__, err);
}

bool duet_task_set_array(duet_task *t, const char *name, const void *elements, uint64_t n,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t i;
    if (!find_arg(t, name, true, __func__, &i, err) ||
        !error_given(elements, __func__, "elements", err))
        return false;
    const task_arg *arg = &t->file->args[i];
    if (arg->access == TASK_OUT || arg->access == TASK_SUM)
        return bad_argument(
            err, "%s: %s is only written, its access is %s; expected an array that is read",
            __func__, name, task_access_name(arg->access));
    if (n != arg->count)
        return bad_argument(err, "%s: %s has %" PRIu64 " elements of %s; expected %" PRIu64,
                            __func__, name, n, arg->type, arg->count);
    task_unbind(t->launcher, i);
    memcpy(task_host_values(t->launcher, i)->bytes, elements, arg->initial.size);
    return true;
}

const void *duet_task_get_array(duet_task *t, const char *name, uint64_t *n, duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t i;
    if (!find_arg(t, name, true, __func__, &i, err) || !task_bound_see(t->launcher, i, err))
        return NULL;
    if (n)
        *n = t->file->args[i].count;
    return task_host_values(t->launcher, i)->bytes;
}

bool duet_task_set_buffer(duet_task *t, const char *name, cl_mem elements, cl_uint n_events,
                          const cl_event *events, duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t i;
    return find_arg(t, name, true, __func__, &i, err) &&
           task_bind(t->launcher, i, elements, n_events, events, __func__, err);
}

// ---------------------------------------------------------------- runs

bool duet_task_run(duet_task *t, duet_task_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(t, __func__, "task", err) || !error_given(result, __func__, "result", err) ||
        !task_launch_unchecked(t->launcher, &t->plan, &t->result, err))
        return false;
    *result = (duet_task_result){.total_ms = t->result.total_ms,
                                 .device_ms = {t->result.device_ms[0], t->result.device_ms[1]},
                                 .stages = t->result.stages,
                                 .n_stages = t->result.n_stages};
    return true;
}
