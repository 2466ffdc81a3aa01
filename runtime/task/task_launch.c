// SPDX-License-Identifier: MIT
#include "runtime/task/task_launch.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/broadphase/variant.h"
#include "runtime/task/task_launcher.h"
#include "runtime/task/task_reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- a device's part

static bool fetch_array(task_side *s, uint32_t i, duet_error *err)
{
    const task *t = s->launcher->task;
    const task_arg *arg = &t->args[i];
    buffer *b = &s->buffers[i];
    size_t from, to;
    if (s->ways[i] == TASK_IN_PLACE)
        return true;
    if (b->host)
        return timeline_read(&s->side.times, "fetch", b, b->host, arg->initial.size, err);
    if (arg->access == TASK_SUM)
        return timeline_read(&s->side.times, "fetch", b, s->partial[i].bytes, arg->initial.size,
                             err);
    task_arg_range(arg, t->items, s->side.first, s->side.last, &from, &to);
    return timeline_read_at(&s->side.times, "fetch", b, from,
                            (char *)s->launcher->results[i].bytes + from, to - from, err);
}

static bool run_part(work_side *w)
{
    task_side *s = (task_side *)w;
    const task *t = s->launcher->task;
    bool ok = task_side_send(s, &w->err) && task_side_launch(s, &w->err);
    for (uint32_t i = 0; ok && i < t->n_args; ++i)
        ok = !task_arg_is_written(&t->args[i]) || fetch_array(s, i, &w->err);
    return ok;
}

// ---------------------------------------------------------------- results

// Puts arrays back to what they hold before a launch.
static void reset_results(task_launcher *l)
{
    for (uint32_t i = 0; i < l->task->n_args; ++i) {
        const task_arg *arg = &l->task->args[i];
        if (arg->kind == TASK_ARG_ARRAY && arg->access == TASK_IN_OUT)
            memcpy(l->results[i].bytes, arg->initial.bytes, arg->initial.size);
    }
}

// The bytes of a written array that belong to a side's items. A sum belongs to the side that has
// the last item.
static void written_range(const task_side *s, uint32_t i, size_t *from, size_t *to)
{
    const task *t = s->launcher->task;
    const work_side *b = &s->launcher->sides[1].side;
    bool is_others = t->args[i].access == TASK_SUM && &s->side != b && b->first < b->last;
    *from = *to = 0;
    if (s->side.first < s->side.last && !is_others)
        task_arg_range(&t->args[i], t->items, s->side.first, s->side.last, from, to);
}

// An array that is read, too, holds again what it does before a launch. One that is only written
// gets bytes that no launch leaves by chance, so that an earlier launch's results are never taken
// for this one's.
static void reset_side(task_side *s)
{
    enum { UNWRITTEN = 0xA5 };
    task_launcher *l = s->launcher;
    for (uint32_t i = 0; i < l->task->n_args; ++i) {
        const task_arg *arg = &l->task->args[i];
        size_t from, to;
        if (arg->kind != TASK_ARG_ARRAY || (arg->access != TASK_IN_OUT && arg->access != TASK_OUT))
            continue;
        char *bytes = l->results[i].bytes;
        written_range(s, i, &from, &to);
        if (arg->access == TASK_IN_OUT)
            memcpy(bytes + from, (const char *)arg->initial.bytes + from, to - from);
        else
            memset(bytes + from, UNWRITTEN, to - from);
    }
}

static void add(task_values *to, const task_values *a, const task_values *b)
{
    bool whole = task_scalar_is_whole(to->scalar);
    for (uint64_t i = 0; whole && i < to->n; ++i)
        task_values_set_whole(to, i,
                              (int64_t)((uint64_t)task_values_get_whole(a, i) +
                                        (uint64_t)task_values_get_whole(b, i)));
    for (uint64_t i = 0; !whole && i < to->n; ++i)
        task_values_set(to, i, task_values_get(a, i) + task_values_get(b, i));
}

// A device's sum lies in its buffer, if that is host memory.
static task_values sum_of(const task_side *s, uint32_t i)
{
    task_values sum = s->partial[i];
    if (s->buffers[i].host)
        sum.bytes = s->buffers[i].host;
    return sum;
}

// Parts of a sum are added; of other arrays each device has left its own part in its place.
static void merge_results(task_launcher *l)
{
    const task_side *a = &l->sides[0], *b = &l->sides[1];
    for (uint32_t i = 0; i < l->task->n_args; ++i) {
        if (l->task->args[i].kind != TASK_ARG_ARRAY || l->task->args[i].access != TASK_SUM)
            continue;
        task_values of_a = sum_of(a, i), of_b = sum_of(b, i);
        bool uses_a = a->side.first < a->side.last, uses_b = b->side.first < b->side.last;
        if (uses_a && uses_b)
            add(&l->results[i], &of_a, &of_b);
        else
            memcpy(l->results[i].bytes, uses_a ? of_a.bytes : of_b.bytes, l->results[i].size);
    }
}

bool task_launch_check(task_launcher *l, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; i < l->task->n_args; ++i)
        for (int side = 0; ok && task_arg_is_written(&l->task->args[i]) && side < 2; ++side) {
            size_t from, to;
            written_range(&l->sides[side], i, &from, &to);
            ok = task_check_bytes(l->task, &l->task->args[i], &l->results[i], from, to, err);
        }
    return ok;
}

// ---------------------------------------------------------------- kernels

// The settings of the kernel in the plan's text.
static bool read_settings(const task_side *s, const char *words, gen_setting *settings, variant *v,
                          uint32_t *n, duet_error *err)
{
    *n = 0;
    if (!variant_parse(v, *words ? words : "auto", &s->side.device->info, err))
        return false;
    for (uint32_t i = 0; i < v->n_settings; ++i)
        if (!*v->settings[i].kernel || strcmp(v->settings[i].kernel, s->call->kernel) == 0)
            settings[(*n)++] = (gen_setting){v->settings[i].name, v->settings[i].value};
    return true;
}

static bool build(task_side *s, const gen_setting *settings, uint32_t n, duet_error *err)
{
    s->kernel = program_set_kernel(s->side.programs, s->call->kernel, s->call->entry, settings, n,
                                   s->call->bindings, err);
    return s->kernel && program_set_build(s->side.programs, err);
}

// Makes the kernel of a variant, unless it is there.
static bool take_variant(task_side *s, const char *words, duet_error *err)
{
    variant v;
    gen_setting settings[VARIANT_SETTINGS];
    uint32_t n;
    if (!s->side.device || (s->call == &s->own && *s->variant && strcmp(s->variant, words) == 0))
        return true;
    s->call = &s->own;
    *s->variant = '\0';
    if (!read_settings(s, words, settings, &v, &n, err) || !build(s, settings, n, err))
        return false;
    snprintf(s->variant, sizeof s->variant, "%s", words);
    return true;
}

// ---------------------------------------------------------------- launches

static bool has_sum(const task *t)
{
    bool has = false;
    for (uint32_t i = 0; i < t->n_args; ++i)
        has |= t->args[i].kind == TASK_ARG_ARRAY && t->args[i].access == TASK_SUM;
    return has;
}

// The host merges from the one time to the other.
static void list_stages(const task_launcher *l, double from_ms, double to_ms, task_result *r)
{
    int n = 0;
    for (int side = 0; side < 2; ++side)
        if (r->device_ms[side] > 0)
            n = timeline_list_stages(&l->sides[side].side.times, side, r->stages, n);
    if (has_sum(l->task))
        r->stages[n++] = (duet_stage){.name = "merge",
                                      .device = 1,
                                      .ms = to_ms - from_ms,
                                      .begin_ms = from_ms,
                                      .end_ms = to_ms};
    r->n_stages = (uint32_t)n;
}

static bool run(task_launcher *l, uint32_t share, task_result *r, duet_error *err)
{
    *r = (task_result){0};
    l->work.share = share;
    uint64_t begun = clock_steady_ns();
    shared_work_divide(&l->work, l->task->items);
    if (!task_bound_load(l, err) || !shared_work_run(&l->work, l->task->items, run_part, err))
        return false;
    double before_ms = clock_ms_since(begun);
    merge_results(l);
    double merged_ms = clock_ms_since(begun);
    if (!task_bound_store(l, err))
        return false;
    r->total_ms = clock_ms_since(begun);
    for (int side = 0; side < 2; ++side)
        r->device_ms[side] = l->sides[side].side.wall_ms;
    list_stages(l, before_ms, merged_ms, r);
    return true;
}

// One device does all of it by itself.
static uint32_t share_of(const task_launcher *l, const duet_plan *plan)
{
    return l->sides[0].side.device ? plan->share : 0;
}

bool task_launcher_prepare(task_launcher *l, const duet_plan *plan, duet_error *err)
{
    return take_variant(&l->sides[0], plan->variant_a, err) &&
           take_variant(&l->sides[1], plan->variant_b, err);
}

bool task_launch_unchecked(task_launcher *l, const duet_plan *plan, task_result *result,
                           duet_error *err)
{
    return shared_work_check(plan->share, err) && task_launcher_prepare(l, plan, err) &&
           run(l, share_of(l, plan), result, err);
}

void task_launch_reset(task_launcher *l, const duet_plan *plan)
{
    l->work.share = share_of(l, plan);
    shared_work_divide(&l->work, l->task->items);
    reset_side(&l->sides[0]);
    reset_side(&l->sides[1]);
}

void task_launcher_set_part(task_launcher *l, uint32_t part)
{
    l->work.part = part;
}

double task_launcher_estimate_ms(const task_launcher *l)
{
    return has_sum(l->task) ? 0 : l->estimate_ms;
}

bool task_launch(task_launcher *l, const duet_plan *plan, task_result *result, duet_error *err)
{
    task_launch_reset(l, plan);
    return task_launch_unchecked(l, plan, result, err) && task_launch_check(l, err);
}

bool task_launch_train(task_launcher *l, const duet_plan *plan, uint32_t n, duet_error *err)
{
    task_result result;
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        task_launch_reset(l, plan);
        ok = budget_check(err) && task_launch_unchecked(l, plan, &result, err);
    }
    return ok && task_launch_check(l, err);
}

bool task_kernel_space(task_launcher *l, const duet_plan *plan, int which, kernel_spaces *to,
                       duet_error *err)
{
    static const char *const stages[KERNEL_SPACE_STAGES] = {"kernel"};
    task_side *s = &l->sides[which];
    if (!s->side.device)
        return true;
    const kernel_space_source from = {.gen = s->side.gen,
                                      .limits = program_set_limits(s->side.programs)};
    return take_variant(s, which == 0 ? plan->variant_a : plan->variant_b, err) &&
           kernel_space_read(&from, l->task->kernel, stages, s->kernel, to, err);
}

// ---------------------------------------------------------------- owner

// Devices that work on host memory share the arrays, each in its own context.
static bool hold_array(task_side *s, uint32_t i, duet_error *err)
{
    task_launcher *l = s->launcher;
    const task_values *v = task_host_values(l, i);
    bool ok = l->task->args[i].access == TASK_SUM
                  ? buffer_reserve(&s->buffers[i], s->side.device, v->size, err) &&
                        task_values_make(&s->partial[i], v->scalar, v->n, err)
                  : buffer_hold(&s->buffers[i], s->side.device, v->bytes, v->size, err);
    s->own.slots[i].mem = s->reference.slots[i].mem = s->buffers[i].mem;
    return ok;
}

static bool open_side(task_side *s, duet_error *err)
{
    const task *t = s->launcher->task;
    if (!s->side.device)
        return true;
    gen_limits limits = program_set_limits(s->side.programs);
    s->call = &s->own;
    if (!task_add_kernels(t, s->side.gen, err) ||
        !task_call_read(&s->own, t, t->kernel, t->entry, s->side.gen, &limits, err) ||
        (*t->reference && !task_call_read(&s->reference, t, t->reference,
                                          strcmp(t->reference, t->kernel) ? t->reference : t->entry,
                                          s->side.gen, &limits, err)))
        return false;
    bool ok = true;
    for (uint32_t i = 0; ok && i < t->n_args; ++i)
        ok = t->args[i].kind != TASK_ARG_ARRAY || hold_array(s, i, err);
    return ok;
}

static bool make_results(task_launcher *l, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < l->task->n_args; ++i) {
        const task_values *v = &l->task->args[i].initial;
        ok = !task_arg_is_written(&l->task->args[i]) ||
             task_values_make(&l->results[i], v->scalar, v->n, err);
    }
    return ok;
}

// Device B alone runs the other kernel, and what that leaves is right.
static bool run_reference(task_launcher *l, duet_error *err)
{
    task_result r;
    task_side *b = &l->sides[1];
    bool known = true;
    for (uint32_t i = 0; i < l->task->n_args; ++i)
        known &= !task_arg_is_written(&l->task->args[i]) || l->task->args[i].expected.bytes;
    if (known)
        return true;
    b->call = &b->reference;
    if (!build(b, NULL, 0, err) || !task_guard_check(l, 0, err) || !run(l, 0, &r, err) ||
        !task_expect_initial(l->task, err))
        return false;
    for (uint32_t i = 0; i < l->task->n_args; ++i)
        if (task_arg_is_written(&l->task->args[i]))
            memcpy(l->task->args[i].expected.bytes, l->results[i].bytes, l->results[i].size);
    return true;
}

static bool open(task_launcher *l, duet_device_pair *pair, duet_error *err)
{
    static const duet_plan usual = {.variant_a = "auto", .variant_b = "auto"};
    uint32_t share = duet_device_pair_is_one(pair) ? 0 : DUET_SHARE_ONE / 2;
    for (int side = 0; side < 2; ++side)
        l->sides[side].launcher = l;
    if (!task_kernel_dir(l->task, pair) && l->task->n_kernels == 0)
        return bad_argument(err,
                            "task %s: neither its def nor the pair says where the kernel's card "
                            "and text are; expected kernels, a folder or a kernel_dir",
                            l->task->name);
    if (!shared_work_open(&l->work, pair, task_kernel_dir(l->task, pair), share, &l->sides[0].side,
                          &l->sides[1].side, err) ||
        !make_results(l, err) || !open_side(&l->sides[0], err) || !open_side(&l->sides[1], err))
        return false;
    reset_results(l);
    return task_launcher_prepare(l, &usual, err);
}

task_launcher *task_launcher_open_unchecked(task *t, duet_device_pair *pair, duet_error *err)
{
    task_launcher *l = calloc(1, sizeof *l);
    if (!l)
        return null_no_memory(err, "task %s", t->name);
    l->task = t;
    if (open(l, pair, err))
        return l;
    task_launcher_close(l);
    return NULL;
}

task_launcher *task_launcher_open(task *t, duet_device_pair *pair, duet_error *err)
{
    task_launcher *l = task_launcher_open_unchecked(t, pair, err);
    bool ok = l && task_guard_check(l, l->work.share, err);
    if (ok)
        l->estimate_ms = fmax(l->sides[0].guarded_ms, l->sides[1].guarded_ms);
    if (ok && run_reference(l, err))
        return l;
    task_launcher_close(l);
    return NULL;
}

void task_launcher_close(task_launcher *l)
{
    if (!l)
        return;
    for (int side = 0; side < 2; ++side)
        for (uint32_t i = 0; i < GEN_MAX_ARGS; ++i) {
            buffer_release(&l->sides[side].buffers[i]);
            task_values_free(&l->sides[side].partial[i]);
        }
    for (uint32_t i = 0; i < GEN_MAX_ARGS; ++i) {
        task_unbind(l, i);
        task_values_free(&l->results[i]);
    }
    if (l->work.pair)
        shared_work_close(&l->work);
    free(l);
}
