// SPDX-License-Identifier: MIT
// A task as a subject: a kernel of the user's, whose items two devices share.
#include "tuner/subject.h"

#include "base/error.h"
#include "runtime/task/task_launch.h"
#include "tuner/tuning.h"

#include <string.h>

// ---------------------------------------------------------------- def

// Each device has its own kernel, and nothing is built by one for the other.
static const duet_mode modes[] = {DUET_MODE_OWN};
static const char *const variants[] = {"auto"};

static bool is_asked(const duet_tune_def *def)
{
    return def->task;
}

static bool check(const duet_tune_def *def, duet_error *err)
{
    const char *other = def->scene                               ? "scene"
                        : def->query                             ? "query"
                        : def->steps                             ? "steps"
                        : def->items                             ? "items of a query"
                        : def->n_modes > 0                       ? "modes"
                        : def->n_levels > 0 || def->has_accuracy ? "level or accuracy"
                        : def->ordered                           ? "order"
                                                                 : NULL;
    return !other ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "a task has no %s; expected none", other);
}

static void complete(duet_tune_def *def)
{
    def->search = def->search ? def->search : "kernels";
    def->modes = modes;
    def->n_modes = sizeof modes / sizeof *modes;
    if (def->n_variants > 0)
        return;
    def->variants = variants;
    def->n_variants = sizeof variants / sizeof *variants;
}

// ---------------------------------------------------------------- owner

static bool open(subject *s, duet_error *err)
{
    s->units = s->def->task->items;
    s->plan.mode = DUET_MODE_OWN;
    plan_set_variants(&s->plan, variants[0]);
    s->state = task_launcher_open(s->def->task, s->pair, err);
    return s->state;
}

static void close(subject *s)
{
    task_launcher_close(s->state);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    if (!profile_subject_read_task(s->def->task, s->pair, p, err))
        return false;
    p->workload.name = s->def->task->name;
    return true;
}

// ---------------------------------------------------------------- launches

// Every launch is checked against what is right, within the task's tolerance: there is no hash.
static bool find_truth(subject *s, subject_truth *truth, duet_error *err)
{
    (void)s;
    (void)err;
    *truth = (subject_truth){0};
    return true;
}

static bool launch(void *context, const duet_plan *plan, bool staged, measure_launch *out,
                   duet_error *err)
{
    subject *s = context;
    task_result r;
    (void)staged;
    core_watch_start(s->cores);
    if (!task_launch(s->state, plan, &r, err))
        return false;
    *out = (measure_launch){.total_ns = measure_to_ns(r.total_ms),
                            .a_ns = measure_to_ns(r.device_ms[0]),
                            .b_ns = measure_to_ns(r.device_ms[1]),
                            .use = core_watch_stop(s->cores),
                            .n_stages = r.n_stages};
    memcpy(out->stages, r.stages, r.n_stages * sizeof *r.stages);
    for (uint32_t i = 0; i < r.n_stages; ++i)
        out->transfer_ns += r.stages[i].transfer ? measure_to_ns(r.stages[i].ms) : 0;
    return true;
}

static bool train(void *context, const duet_plan *plan, uint32_t n, duet_error *err)
{
    return task_launch_train(((subject *)context)->state, plan, n, err);
}

static bool read_kernels(void *context, const duet_plan *plan, int side, kernel_space **spaces,
                         uint32_t *n, duet_error *err)
{
    return task_kernel_space(((subject *)context)->state, plan, side, spaces, n, err);
}

const subject_kind subject_task = {
    .is_asked = is_asked,
    .check = check,
    .complete = complete,
    .open = open,
    .close = close,
    .describe = describe,
    .find_truth = find_truth,
    .launch = launch,
    .train = train,
    .read_kernels = read_kernels,
};
