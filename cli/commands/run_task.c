// SPDX-License-Identifier: MIT
// duet run --task: a kernel of the user's on two devices, every launch checked.
//
// The first launch warms up; of the others the one with the median time is shown.
#include "cli/commands/run.h"

#include "cli/command_text.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/report/run_report.h"
#include "cli/report/time_lines.h"
#include "cli/say.h"
#include "cli/timed.h"
#include "runtime/selection/profile_subject.h"

#include <string.h>

// The report of a run: what it launched, and how long that took.
typedef struct ran {
    const task *task;
    const duet_device_pair *pair;
    duet_plan plan;
    duet_grade grade; // the plan's
    bool given;       // the plan
    timed times;
} ran;

// ---------------------------------------------------------------- the plan

// The plan that was measured for the task on these devices; the default one if none was. A store
// that cannot be read is told of.
static bool find_plan(ran *r, duet_error *err)
{
    profile_subject subject;
    profile_found found = {.grade = PROFILE_DEFAULT};
    duet_error failure = {0};
    if (!profile_subject_read_task(r->task, r->pair, &subject, err))
        return false;
    profile_request request = profile_subject_request(&subject);
    if (!profile_subject_look(NULL, &request, &found, NULL, &failure))
        say_failed(&failure);
    r->grade = found.grade < PROFILE_STALE ? (duet_grade)found.grade : DUET_GRADE_DEFAULT;
    return found.grade >= PROFILE_STALE || profile_subject_read_plan(&found.plan, &r->plan, err);
}

static bool choose_plan(const arguments *args, ran *r, duet_error *err)
{
    r->plan = duet_default_plan(r->pair);
    r->plan.mode = DUET_MODE_OWN;
    strcpy(r->plan.variant_a, "auto");
    strcpy(r->plan.variant_b, "auto");
    r->grade = DUET_GRADE_DEFAULT;
    r->given = inputs_plan_given(&args->plan);
    return r->given ? inputs_change_plan(&args->plan, r->pair, args->pair, &r->plan, err)
                    : find_plan(r, err);
}

// ---------------------------------------------------------------- the report

static void add_tuning(cJSON *o, const arguments *args, const ran *r)
{
    text tuning = {0};
    text_add(&tuning, "duet tune");
    command_text_option(&tuning, "task", args->task);
    command_text_settings(&tuning, &args->scene);
    command_text_pair(&tuning, r->pair);
    json_add(o, STRING("tuning", text_chars(&tuning)));
    text_free(&tuning);
}

static bool report(const arguments *args, const ran *r, duet_error *err)
{
    const timed_step *m = timed_median(&r->times);
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("task", r->task->name), STRING("kernel", r->task->kernel),
             NUMBER("items", r->task->items));
    run_report_add_plan(o, r->pair, &r->plan);
    json_add(o, STRING("plan_from", r->given ? "given" : duet_grade_name(r->grade)),
             NUMBER("total_ms", m->total_ms), NUMBER("least_ms", r->times.steps[0].total_ms),
             NUMBER("most_ms", r->times.steps[r->times.n - 1].total_ms),
             NUMBER("a_ms", m->device_ms[0]), NUMBER("b_ms", m->device_ms[1]),
             NUMBER("launches", r->times.n), NUMBER("tolerance", r->task->tolerance),
             STRING("reference", r->task->reference));
    if (!args->json)
        add_tuning(o, args, r);
    json_add_stages(o, m->stages, m->n_stages);
    return rendering_tell(o, args->json, "cli/report/run_task.lua", err);
}

// Compiles, and launches the kernel between guards, which may take seconds.
static task_launcher *open_launcher(task *t, duet_device_pair *pair, duet_error *err)
{
    progress shown = progress_begin("checking the kernel", 0);
    progress_show(&shown, 0);
    task_launcher *l = task_launcher_open(t, pair, err);
    progress_end(&shown);
    return l;
}

static bool time_launches(ran *r, task_launcher *l, uint32_t repeat, duet_error *err)
{
    progress shown = progress_begin("launching the kernel", 0);
    progress_show(&shown, 0);
    bool ok = timed_task_run(&r->times, l, r->pair, &r->plan, repeat, err);
    progress_end(&shown);
    return ok;
}

static bool run_on(const arguments *args, task *t, duet_device_pair *pair, duet_error *err)
{
    ran r = {.task = t, .pair = pair};
    task_launcher *l = open_launcher(t, pair, err);
    bool ok = l && choose_plan(args, &r, err) &&
              time_launches(&r, l, (uint32_t)args->repeat, err) &&
              time_lines_write(args->timeline, t->name, pair, &r.plan, timed_median(&r.times), err);
    if (ok && (args->json || !options_is_stdout(args->timeline)))
        ok = report(args, &r, err);
    timed_free(&r.times);
    task_launcher_close(l);
    return ok;
}

bool run_task(const arguments *args, duet_error *err)
{
    task *t = inputs_load_task(args->task, &args->scene, err);
    duet_device_pair *pair = t ? inputs_open_pair(args->pair, err) : NULL;
    bool ok = pair && run_on(args, t, pair, err);
    duet_device_pair_destroy(pair);
    task_destroy(t);
    return ok;
}
