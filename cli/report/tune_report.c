// SPDX-License-Identifier: MIT
// The rows are kept as the JSON that --json prints; the table reads them back.
#define _POSIX_C_SOURCE 200809L
#include "cli/report/tune_report.h"

#include "cli/interrupt.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "tuner/measure.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

tune_report tune_report_begin(bool json)
{
    interrupt_watch();
    return (tune_report){
        .workloads = cJSON_CreateArray(), .json = json, .on_terminal = isatty(STDERR_FILENO)};
}

void tune_report_workload(tune_report *r, const duet_scene_info *scene)
{
    snprintf(r->name, sizeof r->name, "%.30s, %s", scene->name, table_count(scene->n).chars);
}

static void clear_line(const tune_report *r)
{
    if (r->on_terminal)
        fprintf(stderr, "\r\033[K");
}

bool tune_report_watch(void *report, const duet_tune_progress *p)
{
    const tune_report *r = report;
    if (r->on_terminal) {
        clear_line(r);
        if (p->trials == 0) {
            fprintf(stderr, "%s: levels of accuracy; step %u, %.1f s", r->name, p->launches,
                    p->seconds);
            return !interrupt_asked();
        }
        fprintf(stderr, "%s: %s %.4f, %s grids, %s|%s: %.3f ms; trial %u, %.1f s%s", r->name,
                p->stage, p->plan->share / (double)DUET_SHARE_ONE, duet_mode_name(p->plan->mode),
                p->plan->variant_a, p->plan->variant_b, p->ms, p->trials, p->seconds,
                p->remembered ? ", remembered" : "");
    }
    return !interrupt_asked();
}

// ---------------------------------------------------------------- rows

static void variant_of(const duet_plan *plan, char both[200])
{
    bool same = strcmp(plan->variant_a, plan->variant_b) == 0;
    snprintf(both, 200, "%s%s%s", plan->variant_a, same ? "" : " | ", same ? "" : plan->variant_b);
}

static void add_terms(cJSON *o, const duet_tune_terms *t)
{
    cJSON *terms = cJSON_AddObjectToObject(o, "terms");
    for (const terms_field *f = terms_fields; f->name; ++f)
        cJSON_AddNumberToObject(terms, f->name, terms_value(f, t));
}

// Steps after which the time that tuning took is won back; 0 where it is not,
// or where it was not measured here.
static double break_even(const duet_tune_outcome *o)
{
    double won_ms = o->single_ms - o->step_ms;
    return won_ms > 0 ? ceil(o->seconds * 1e3 / won_ms) : 0;
}

void tune_report_add(tune_report *r, const duet_tune_outcome *o)
{
    char variant[200];
    cJSON *row = cJSON_CreateObject();
    variant_of(&o->plan, variant);
    cJSON_AddStringToObject(row, "workload", r->name);
    cJSON_AddNumberToObject(row, "objects", o->objects);
    cJSON_AddStringToObject(row, "level", duet_level_get_info(o->level)->name);
    cJSON_AddNumberToObject(row, "missed_rate", o->accuracy.missed);
    cJSON_AddNumberToObject(row, "false_rate", o->accuracy.false_rate);
    cJSON_AddNumberToObject(row, "true_pairs", (double)o->true_pairs);
    cJSON_AddNumberToObject(row, "share", o->plan.share / (double)DUET_SHARE_ONE);
    cJSON_AddNumberToObject(row, "best_share", o->best.share / (double)DUET_SHARE_ONE);
    cJSON_AddStringToObject(row, "mode", duet_mode_name(o->plan.mode));
    cJSON_AddStringToObject(row, "variant", variant);
    cJSON_AddNumberToObject(row, "gain", o->gain);
    cJSON_AddNumberToObject(row, "gain_low", o->gain_low);
    cJSON_AddNumberToObject(row, "gain_high", o->gain_high);
    cJSON_AddStringToObject(row, "verdict", o->verdict);
    cJSON_AddNumberToObject(row, "step_ms", o->step_ms);
    cJSON_AddNumberToObject(row, "single_ms", o->single_ms);
    cJSON_AddNumberToObject(row, "launches", o->launches);
    cJSON_AddNumberToObject(row, "seconds", o->seconds);
    cJSON_AddNumberToObject(row, "break_even_steps", break_even(o));
    cJSON_AddBoolToObject(row, "resumed", o->known || o->resumed);
    add_terms(row, &o->terms);
    cJSON_AddItemToArray(r->workloads, row);
    clear_line(r);
}

// ---------------------------------------------------------------- printing

static double number(const cJSON *row, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(row, name);
    return item ? item->valuedouble : 0;
}

static const char *string(const cJSON *row, const char *name)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(row, name));
}

// Certified needs no word: nothing of it is wrong.
static void print_accuracy(const cJSON *row)
{
    if (strcmp(string(row, "level"), "certified") == 0)
        return;
    printf("%s: of %s pairs that collide '%s' misses %.3g %% and invents %.3g %%\n",
           say_name(string(row, "workload")).chars,
           table_count((uint64_t)number(row, "true_pairs")).chars, string(row, "level"),
           100 * number(row, "missed_rate"), 100 * number(row, "false_rate"));
}

static void print_table(const cJSON *workloads)
{
    static const char *const heads[] = {"workload", "level",   "share", "mode", "kernels",
                                        "ms",       "gain",    "from",  "to",   "verdict",
                                        "launches", "seconds", ""};
    table t = table_begin("llrllrrrrlrrl");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i)
        table_cell(&t, "%s", heads[i]);
    const cJSON *row;
    cJSON_ArrayForEach(row, workloads)
    {
        table_cell(&t, "%s", string(row, "workload"));
        table_cell(&t, "%s", string(row, "level"));
        table_cell(&t, "%.4f", number(row, "share"));
        table_cell(&t, "%s", string(row, "mode"));
        table_cell(&t, "%s", string(row, "variant"));
        table_cell(&t, "%.3f", number(row, "step_ms"));
        table_cell(&t, "%+.1f %%", 100 * number(row, "gain"));
        table_cell(&t, "%+.1f", 100 * number(row, "gain_low"));
        table_cell(&t, "%+.1f", 100 * number(row, "gain_high"));
        table_cell(&t, "%s", string(row, "verdict"));
        table_cell(&t, "%.0f", number(row, "launches"));
        table_cell(&t, "%.1f", number(row, "seconds"));
        table_cell(&t, "%s",
                   cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(row, "resumed")) ? "known" : "");
    }
    table_print(&t, stdout);
    cJSON_ArrayForEach(row, workloads) print_accuracy(row);
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
        print_table(r->workloads);
    cJSON_Delete(r->workloads);
    return true;
}
