// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/report/tune_report.h"

#include "cli/command_text.h"
#include "cli/interrupt.h"
#include "cli/report/table.h"
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

void tune_report_workload(tune_report *r, const duet_scene_info *scene, const duet_tune_def *def)
{
    r->task = NULL;
    r->query = def->query;
    r->items = def->items ? def->items : scene->n;
    r->steps = def->steps;
    snprintf(r->name, sizeof r->name, "%.30s, %s", scene->name, table_count(scene->n).chars);
    ++r->number;
}

void tune_report_task(tune_report *r, const task *t)
{
    r->task = t->kernel;
    r->query = NULL;
    r->steps = 0;
    r->items = t->items;
    snprintf(r->name, sizeof r->name, "%.30s, %s", t->name, table_count(t->size).chars);
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
        text_add(shown, "; waiting, Ctrl-C keeps what was measured");
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
    if (left >= 0)
        text_add(shown, ", < %.0f s left", left);
    text_add(shown, "%s", p->remembered ? " (measured before)" : "");
}

// Without a terminal a line when the tuning begins to wait.
static void log_waiting(tune_report *r, const duet_tune_progress *p)
{
    if (p->waiting && !r->waits)
        fprintf(stderr, "%.22s: %s; waiting\n", r->name, p->waiting);
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

static void add_command(cJSON *row, const duet_tune_outcome *o, bool one, bool is_task,
                        text *command)
{
    if (command->length == 0)
        return;
    command_text_plan(command, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                      o->plan.variant_a, o->plan.variant_b, one);
    if (!is_task)
        command_text_option(command, "level", duet_level_get_info(o->level)->name);
    json_add(row, STRING("command", text_chars(command)));
}

void tune_report_add(tune_report *r, const duet_tune_outcome *o, text *command)
{
    cJSON *row = json_add_row(r->workloads);
    json_add(row, STRING("workload", r->name), NUMBER("objects", o->objects));
    if (r->query || r->task) {
        json_add(row, STRING(r->task ? "task" : "query", r->task ? r->task : r->query),
                 NUMBER("items", r->items));
    }
    if (r->steps)
        json_add(row, NUMBER("steps", r->steps));
    json_add(row, STRING("level", duet_level_get_info(o->level)->name));
    json_add_rates(row, (double)o->true_pairs, o->accuracy.missed, o->accuracy.false_rate);
    json_add_plan(row, o->plan.share / (double)DUET_SHARE_ONE, duet_mode_name(o->plan.mode),
                  o->plan.variant_a, o->plan.variant_b);
    add_command(row, o, r->one, r->task, command);
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
    add_terms(row, &o->terms);
    add_kernels(row, o);
    if (o->plans > 0) {
        json_add(row, NUMBER("plans", o->plans), NUMBER("plans_tried", o->plans_tried));
    }
    clear_line(r);
}

// Certified needs no word: nothing of it is wrong.
static void print_accuracy(const cJSON *row)
{
    if (strcmp(json_string(row, "level"), "certified") == 0)
        return;
    printf("  of %s pairs that collide, '%s' misses %.3g %% and adds %.3g %% that are false\n",
           table_count((uint64_t)json_number(row, "true_pairs")).chars, json_string(row, "level"),
           100 * json_number(row, "missed_rate"), 100 * json_number(row, "false_rate"));
}

// A store keeps no energy of a device alone.
static void print_energy(const cJSON *row)
{
    printf("  energy: %.6g J a launch", json_number(row, "joules"));
    if (json_number(row, "single_joules") > 0)
        printf(", %.6g J by the better device alone", json_number(row, "single_joules"));
    printf("; the gain is of energy\n");
}

static void print_search(const cJSON *o)
{
    const char *verdict = json_string(o, "verdict"), *variant = json_string(o, "variant");
    printf("  kernels of %s: %.0f of %.0f sets of parameters tried in %.0f launches:\n    ",
           json_string(o, "device"), json_number(o, "tried"), json_number(o, "configs"),
           json_number(o, "launches"));
    if (strcmp(verdict, "faster") == 0)
        printf("%.1f %% faster (%.1f to %.1f) by '%s'\n", 100 * json_number(o, "gain"),
               100 * json_number(o, "gain_low"), 100 * json_number(o, "gain_high"), variant);
    else if (strcmp(verdict, "ambiguous") == 0)
        printf("none was surely faster; '%s' stays\n", variant);
    else
        printf("no faster set was found; '%s' stays\n", variant);
}

static void print_kernels(const cJSON *row)
{
    const cJSON *one;
    cJSON_ArrayForEach(one, json_list(row, "kernels")) print_search(one);
}

// The share as it is stored.
static uint32_t share_of(const cJSON *row)
{
    return (uint32_t)lround(json_number(row, "share") * DUET_SHARE_ONE);
}

// A tuning that gave up knows no time.
static bool gave_up(const cJSON *row)
{
    return json_number(row, "step_ms") == 0;
}

static bool is_shared(const cJSON *row)
{
    return !gave_up(row) && share_of(row) > 0 && share_of(row) < DUET_SHARE_ONE;
}

static void add_step(table *t, const cJSON *row)
{
    if (gave_up(row))
        table_words(t, "-", NULL);
    else
        table_cell(t, "%.3f", json_number(row, "step_ms"));
}

static void add_table_row(table *t, const cJSON *row)
{
    table_cell(t, "%.22s", json_string(row, "workload"));
    if (gave_up(row))
        table_words(t, "the default", NULL);
    else if (is_shared(row))
        table_cell(t, "A %.2f %%", 100 * json_number(row, "share"));
    else
        table_words(t, share_of(row) == 0 ? "B alone" : "A alone", NULL);
    add_step(t, row);
    if (is_shared(row)) {
        table_cell(t, "%+.1f", 100 * json_number(row, "gain"));
        table_cell(t, "%+.1f", 100 * json_number(row, "gain_low"));
        table_cell(t, "%+.1f", 100 * json_number(row, "gain_high"));
        table_words(t, json_string(row, "verdict"), NULL);
    } else {
        table_words(t, "-", "", "", gave_up(row) ? json_string(row, "verdict") : "-", NULL);
    }
    table_cell(t, "%.1f", json_number(row, "seconds"));
}

static void print_use_command(const tune_report *r, const cJSON *row)
{
    text command = {0};
    text_add(&command, "duet profiles use %.8s", json_string(row, "uid"));
    if (r->store_path)
        command_text_option(&command, "profile", r->store_path);
    command_text_print(text_chars(&command), stdout);
    text_free(&command);
}

// Why a plan is not loaded, and what would change that.
static void print_use(const tune_report *r, const cJSON *row)
{
    const char *unused = json_string(row, "unused");
    if (!*unused)
        return;
    printf("  not used by applications: %s\n", unused);
    if (gave_up(row)) {
        printf(
            "  the same command goes on from here; --wait SECONDS waits longer, --wait 0 measures "
            "beside them\n");
        return;
    }
    if (strcmp(json_string(row, "verdict"), "ambiguous") == 0) {
        printf("  the same command tunes again; a larger --budget allows more rounds\n");
        return;
    }
    printf("  to make them use it:\n");
    print_use_command(r, row);
}

// Prints what the table has no column for.
static void print_details(const tune_report *r, const cJSON *row)
{
    const char *query = json_string(row, "query");
    printf("\n%s, ", say_name(json_string(row, "workload")).chars);
    if (*query)
        printf("%s %s", table_count((uint64_t)json_number(row, "items")).chars,
               say_name(query).chars);
    else if (*json_string(row, "task"))
        printf("%s items of kernel %s", table_count((uint64_t)json_number(row, "items")).chars,
               json_string(row, "task"));
    else if (json_number(row, "steps") > 0)
        printf("runs of %.0f steps", json_number(row, "steps"));
    else
        printf("level %s", json_string(row, "level"));
    printf(", %.0f launches\n", json_number(row, "launches"));
    if (json_number(row, "disturbed") > 0)
        printf("  %.0f of %.0f launches waited for a core\n", json_number(row, "disturbed"),
               json_number(row, "watched"));
    if (gave_up(row)) {
        print_use(r, row);
        return;
    }
    if (*json_string(row, "command"))
        command_text_print(json_string(row, "command"), stdout);
    if (!is_shared(row) && !json_true(row, "one_device"))
        printf("  %s\n",
               table_gain(share_of(row), json_number(row, "gain"), json_number(row, "gain_low"),
                          json_number(row, "gain_high"), json_string(row, "verdict"))
                   .chars);
    if (json_number(row, "whole_ms") > 0)
        printf("  %s\n",
               table_whole(json_string(row, "whole"), json_string(row, "whole"),
                           json_number(row, "whole_gain"), json_number(row, "whole_gain_low"),
                           json_number(row, "whole_gain_high"))
                   .chars);
    if (!*query)
        print_accuracy(row);
    print_use(r, row);
    if (json_true(row, "known"))
        printf("  known: the same was measured before; --fresh measures it again\n");
    print_kernels(row);
    if (json_number(row, "joules") > 0)
        print_energy(row);
    if (json_number(row, "plans") > 0)
        printf("  kernels and share together: %.0f of %.0f plans tried\n",
               json_number(row, "plans_tried"), json_number(row, "plans"));
}

static void print_shares(const cJSON *workloads)
{
    table t = table_begin("llrrrrlr");
    table_words(&t, "workload", "plan", "ms", "gain %", "from", "to", "verdict", "seconds", NULL);
    const cJSON *row;
    cJSON_ArrayForEach(row, workloads) add_table_row(&t, row);
    table_print(&t, stdout);
    printf("plan: A's part of the work; B does the rest. ms: a step by this plan.\n"
           "gain: by how much it is faster than the better device alone; it lies between\n"
           "'from' and 'to' with 99 %% confidence.\n");
}

// One device has no share, and nothing to gain over: its kernels were chosen.
static void print_choices(const cJSON *workloads)
{
    table t = table_begin("llrr");
    table_words(&t, "workload", "kernels", "ms", "seconds", NULL);
    const cJSON *row;
    cJSON_ArrayForEach(row, workloads)
    {
        table_cell(&t, "%.22s", json_string(row, "workload"));
        table_cell(&t, "%.40s", json_string(row, "variant_b"));
        add_step(&t, row);
        table_cell(&t, "%.1f", json_number(row, "seconds"));
    }
    table_print(&t, stdout);
    printf(
        "kernels: the usual ones of the device, or others that are faster with 99 %% confidence.\n"
        "ms: a step with them.\n");
}

static void print_workloads(const tune_report *r)
{
    if (r->one)
        print_choices(r->workloads);
    else
        print_shares(r->workloads);
    const cJSON *row;
    cJSON_ArrayForEach(row, r->workloads) print_details(r, row);
}

bool tune_report_end(tune_report *r, bool ok, duet_error *err)
{
    clear_line(r);
    if (r->json && ok) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddItemToObject(o, "workloads", r->workloads);
        return say_json(o, err);
    }
    if (!r->json && cJSON_GetArraySize(r->workloads) > 0)
        print_workloads(r);
    cJSON_Delete(r->workloads);
    return true;
}
