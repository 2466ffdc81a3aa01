// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/report/tune_report.h"

#include "cli/command_text.h"
#include "cli/interrupt.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "runtime/task/task.h"
#include "tuner/terms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

tune_report tune_report_begin(bool json, const char *store_path)
{
    return (tune_report){.workloads = cJSON_CreateArray(),
                         .store_path = store_path,
                         .json = json,
                         .on_terminal = isatty(STDERR_FILENO)};
}

void tune_report_expect(tune_report *r, const duet_device_pair *pair, uint32_t n_workloads,
                        double budget_seconds)
{
    const char *a = duet_device_pair_get_info(pair, 0)->selector;
    r->one = duet_device_pair_is_one(pair);
    snprintf(r->whole, sizeof r->whole, "%.*s", (int)strcspn(a, "["), a);
    r->n_workloads = n_workloads;
    r->budget_seconds = budget_seconds;
}

void tune_report_workload(tune_report *r, const duet_tune_def *def)
{
    const task *t = def->task;
    const duet_scene_info *scene = t ? NULL : duet_scene_get_info(def->scene);
    r->def = def;
    r->items = t ? t->items : def->items ? def->items : scene->n;
    snprintf(r->name, sizeof r->name, "%.30s, %s", t ? t->name : scene->name,
             say_count(t ? t->size : scene->n).chars);
    ++r->number;
}

static void clear_line(const tune_report *r)
{
    if (r->on_terminal)
        fprintf(stderr, "\r\033[K");
}

// At most, by the trials or the time that are left; below 0 if nothing bounds it.
static double seconds_left(const tune_report *r, const duet_tune_progress *p)
{
    double by_time = r->budget_seconds > 0 ? fmax(r->budget_seconds - p->seconds, 0) : -1;
    if (p->trials == 0 || p->most_trials < p->trials)
        return by_time;
    double by_trials = p->seconds / p->trials * (p->most_trials - p->trials);
    return by_time < 0 ? by_trials : fmin(by_time, by_trials);
}

static void write_progress(const tune_report *r, const duet_tune_progress *p, text *shown)
{
    double left = seconds_left(r, p);
    text_add(shown, "%u/%u %.22s: %s", r->number, r->n_workloads, r->name,
             p->waiting ? p->waiting : p->stage);
    if (p->waiting) {
        text_add(shown, "; waiting: Ctrl-C, and --wait 0 does not");
        return;
    }
    if (p->trials == 0) {
        text_add(shown, ", step %u, %.1f s", p->launches, p->seconds);
        return;
    }
    if (!r->one)
        text_add(shown, " at %.4g %s", p->plan->share / (double)DUET_SHARE_ONE,
                 duet_mode_name(p->plan->mode));
    text_add(shown, ", trial %u", p->trials);
    if (p->most_trials > 0)
        text_add(shown, " of %u", p->most_trials);
    const double expected = p->expected_seconds - p->seconds;
    if (expected > 0 && (left < 0 || expected < left))
        text_add(shown, ", about %.0f s left", expected);
    else if (left >= 0)
        text_add(shown, ", < %.0f s left", left);
    text_add(shown, "%s", p->remembered ? " (measured before)" : "");
}

// Without a terminal a line when the tuning begins to wait.
static void log_waiting(tune_report *r, const duet_tune_progress *p)
{
    if (p->waiting && !r->waits)
        fprintf(stderr, "%.22s: %s; waiting: --wait 0 does not\n", r->name, p->waiting);
    r->waits = p->waiting;
}

bool tune_report_watch(void *report, const duet_tune_progress *p)
{
    tune_report *r = report;
    if (!r->on_terminal)
        log_waiting(r, p);
    else {
        text shown = {0};
        write_progress(r, p, &shown);
        progress_line(text_chars(&shown));
        text_free(&shown);
    }
    return !interrupt_asked();
}

static void add_terms(cJSON *o, const duet_tune_terms *t)
{
    cJSON *terms = cJSON_AddObjectToObject(o, "terms");
    for (const terms_field *f = terms_fields; f->name; ++f)
        json_add(terms, NUMBER(f->name, terms_value(f, t)));
}

// The searches of either device's kernels.
static void add_kernels(cJSON *row, const duet_tune_outcome *o)
{
    cJSON *list = cJSON_AddArrayToObject(row, "kernels");
    for (int device = 0; device < 2; ++device) {
        const duet_kernel_search *k = &o->kernels[device];
        if (k->configs == 0)
            continue;
        cJSON *one = json_add_row(list);
        json_add(one, STRING("device", device == 0 ? "A" : "B"),
                 STRING("variant", device == 0 ? o->plan.variant_a : o->plan.variant_b),
                 NUMBER("configs", k->configs), NUMBER("tried", k->tried),
                 NUMBER("launches", k->launches),
                 INTERVAL("gain", k->gain, k->gain_low, k->gain_high),
                 STRING("verdict", k->verdict));
    }
}

// Steps after which the time that tuning took is won back; NaN if it is not, or if it was not
// measured here.
static double break_even(const duet_tune_outcome *o)
{
    double won_ms = o->single_ms - o->step_ms;
    return won_ms > 0 && !o->known ? ceil(o->seconds * 1e3 / won_ms) : NAN;
}

// Steps of a motion, and tasks, have no level.
static void add_command(cJSON *row, const duet_tune_outcome *o, bool one, bool has_level,
                        text *command)
{
    if (command->length == 0)
        return;
    command_text_plan(command, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                      o->plan.variant_a, o->plan.variant_b, one);
    if (has_level)
        command_text_option(command, "level", duet_level_get_info(o->level)->name);
    json_add(row, STRING("command", text_chars(command)));
}

// Has applications use a plan that they do not take by themselves.
static void add_use(cJSON *row, const tune_report *r, const duet_tune_outcome *o)
{
    text use = {0};
    if (!*o->unused)
        return;
    text_add(&use, "duet profiles use %.8s", o->uid);
    if (r->store_path)
        command_text_option(&use, "profile", r->store_path);
    json_add(row, STRING("use_command", text_chars(&use)));
    text_free(&use);
}

void tune_report_add(tune_report *r, const duet_tune_outcome *o, text *command)
{
    const duet_tune_def *def = r->def;
    cJSON *row = json_add_row(r->workloads);
    json_add(row, STRING("workload", r->name), NUMBER("objects", o->objects));
    if (def->task)
        json_add(row, STRING("task", def->task->kernel), NUMBER("items", r->items));
    if (def->query)
        json_add(row, STRING("query", def->query), NUMBER("items", r->items));
    if (def->steps)
        json_add(row, NUMBER("steps", def->steps));
    json_add(row, STRING("level", duet_level_get_info(o->level)->name));
    json_add_rates(row, (double)o->true_pairs, o->accuracy.missed, o->accuracy.false_rate);
    json_add_plan(row, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                  o->plan.variant_a, o->plan.variant_b);
    add_command(row, o, r->one, !def->task && !def->steps, command);
    json_add(row, FLAG("one_device", r->one),
             NUMBER("best_share", o->best.share / (double)DUET_SHARE_ONE),
             INTERVAL("gain", o->gain, o->gain_low, o->gain_high), STRING("verdict", o->verdict),
             NUMBER("step_ms", o->step_ms > 0 ? o->step_ms : NAN), NUMBER("rounds", o->rounds),
             NUMBER("watched", o->watched), NUMBER("disturbed", o->disturbed),
             NUMBER("single_ms", o->single_ms));
    if (o->terms.joules > 0) {
        json_add(row, NUMBER("joules", o->terms.joules), NUMBER("single_joules", o->single_joules));
    }
    if (o->whole_ms > 0)
        json_add(row, STRING("whole", r->whole));
    json_add_whole(row, o->whole_ms, o->whole_gain, o->whole_gain_low, o->whole_gain_high);
    json_add(row, NUMBER("launches", o->launches), NUMBER("seconds", o->seconds),
             NUMBER("break_even_steps", break_even(o)), FLAG("known", o->known),
             FLAG("resumed", o->resumed), STRING("uid", o->uid), STRING("unused", o->unused));
    add_use(row, r, o);
    add_terms(row, &o->terms);
    add_kernels(row, o);
    if (o->plans > 0) {
        json_add(row, NUMBER("plans", o->plans), NUMBER("plans_tried", o->plans_tried));
    }
    clear_line(r);
}

bool tune_report_end(tune_report *r, bool ok, duet_error *err)
{
    clear_line(r);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddItemToObject(o, "workloads", r->workloads);
    if (ok || !r->json)
        return rendering_tell(o, r->json, "cli/report/tune.lua", err);
    cJSON_Delete(o);
    return true;
}
