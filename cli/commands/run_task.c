// SPDX-License-Identifier: MIT
// duet run --task: a kernel of the user's on two devices, every launch checked.
//
// The first launch warms up; of the others the one with the median time is shown.
#include "cli/commands/run.h"

#include "base/error.h"
#include "cli/command_text.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/run_report.h"
#include "cli/report/table.h"
#include "cli/report/time_lines.h"
#include "cli/say.h"
#include "runtime/selection/profile_subject.h"
#include "runtime/task/task_launch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The report of a run: what it launched, and how long that took.
typedef struct ran {
    const task *task;
    const duet_device_pair *pair;
    duet_plan plan;
    duet_grade grade;     // of the plan
    bool given;           // the plan
    task_result *results; // by their time
    uint32_t n;
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

// ---------------------------------------------------------------- launches

static int compare_times(const void *a, const void *b)
{
    double x = ((const task_result *)a)->total_ms, y = ((const task_result *)b)->total_ms;
    return (x > y) - (x < y);
}

static bool launch_all(const arguments *args, task_launcher *l, ran *r, duet_error *err)
{
    task_result first;
    r->results = calloc(args->repeat, sizeof *r->results);
    if (!r->results)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for times");
    bool ok = task_launch(l, &r->plan, &first, err);
    for (; ok && r->n < args->repeat && !interrupt_asked(); ++r->n)
        ok = task_launch(l, &r->plan, &r->results[r->n], err);
    if (ok)
        qsort(r->results, r->n, sizeof *r->results, compare_times);
    return ok && interrupt_check(err);
}

// ---------------------------------------------------------------- the report

static void print_stages(const task_result *m)
{
    table t = table_begin("lrr");
    table_words(&t, "", "A ms", "B ms", NULL);
    for (uint32_t i = 0; i < m->n_stages; ++i) {
        bool seen = false;
        double ms[2] = {0, 0};
        for (uint32_t k = 0; k < m->n_stages; ++k) {
            bool same = strcmp(m->stages[k].name, m->stages[i].name) == 0;
            seen |= same && k < i;
            ms[m->stages[k].device] += same ? m->stages[k].ms : 0;
        }
        if (seen)
            continue;
        table_words(&t, m->stages[i].name, NULL);
        table_cell(&t, "%.3f", ms[0]);
        table_cell(&t, "%.3f", ms[1]);
    }
    table_words(&t, "together", NULL);
    table_cell(&t, "%.3f", m->device_ms[0]);
    table_cell(&t, "%.3f", m->device_ms[1]);
    table_print(&t, stdout);
}

static void print_plan(const arguments *args, const ran *r)
{
    text tuning = {0};
    if (r->given || r->grade < DUET_GRADE_DEFAULT) {
        printf(r->given ? "plan: as given\n\n" : "plan: from the profile, %s\n\n",
               duet_grade_name(r->grade));
        return;
    }
    printf("plan: the default; to measure a better one:\n");
    text_add(&tuning, "duet tune");
    command_text_option(&tuning, "task", args->task);
    command_text_settings(&tuning, &args->scene);
    command_text_pair(&tuning, r->pair);
    command_text_print(text_chars(&tuning), stdout);
    text_free(&tuning);
    putchar('\n');
}

static void print_right(const task *t)
{
    if (t->tolerance > 0)
        printf("right: every launch, within %g of what the task expects\n", t->tolerance);
    else
        printf("right: every launch, exactly what the task expects\n");
}

static void print_text(const arguments *args, const ran *r)
{
    const task_result *m = &r->results[r->n / 2];
    printf("%s: %s items of kernel %s\n", say_name(r->task->name).chars,
           table_count(r->task->items).chars, r->task->kernel);
    run_report_devices(r->pair, &r->plan);
    print_plan(args, r);
    print_stages(m);
    printf("\ntime: %.3f ms, median of %u, %.3f to %.3f; %s items a second\n", m->total_ms, r->n,
           r->results[0].total_ms, r->results[r->n - 1].total_ms,
           table_rate(m->total_ms > 0 ? (double)r->task->items / m->total_ms * 1e3 : 0).chars);
    print_right(r->task);
}

static bool print_json(const ran *r, duet_error *err)
{
    const task_result *m = &r->results[r->n / 2];
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("task", r->task->name), STRING("kernel", r->task->kernel),
             NUMBER("items", r->task->items));
    json_add_plan(o, r->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(r->plan.mode),
                  r->plan.variant_a, r->plan.variant_b);
    json_add(o, STRING("plan_from", r->given ? "given" : duet_grade_name(r->grade)),
             NUMBER("total_ms", m->total_ms), NUMBER("a_ms", m->device_ms[0]),
             NUMBER("b_ms", m->device_ms[1]), NUMBER("launches", r->n),
             NUMBER("tolerance", r->task->tolerance));
    return say_json(o, err);
}

static bool draw_timeline(const arguments *args, const ran *r, duet_error *err)
{
    const task_result *m = &r->results[r->n / 2];
    const time_lines shown = {.title = r->task->name,
                              .pair = r->pair,
                              .plan = &r->plan,
                              .total_ms = m->total_ms,
                              .stages = m->stages,
                              .n_stages = m->n_stages};
    return !args->timeline || time_lines_write(&shown, args->timeline, err);
}

static bool run_on(const arguments *args, task *t, duet_device_pair *pair, duet_error *err)
{
    ran r = {.task = t, .pair = pair};
    task_launcher *l = task_launcher_open(t, pair, err);
    bool ok = l && choose_plan(args, &r, err) && launch_all(args, l, &r, err) &&
              draw_timeline(args, &r, err);
    if (ok && args->json)
        ok = print_json(&r, err);
    else if (ok && !options_is_stdout(args->timeline))
        print_text(args, &r);
    free(r.results);
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
