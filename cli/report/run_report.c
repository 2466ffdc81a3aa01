// SPDX-License-Identifier: MIT
#include "cli/report/run_report.h"

#include "cli/command_text.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

bool reference_check_is_right(const reference_check *check)
{
    return check->missing == 0 && check->extra == 0;
}

// ---------------------------------------------------------------- as text

void run_report_scene(const duet_scene_info *info)
{
    static const char *const kinds[DUET_SHAPES][2] = {
        [DUET_SHAPE_POSES] = {"box", "boxes"},
        [DUET_SHAPE_BOUNDS] = {"axis-aligned box", "axis-aligned boxes"},
        [DUET_SHAPE_ROUNDED_BOXES] = {"rounded box", "rounded boxes"},
        [DUET_SHAPE_SPHERES] = {"sphere", "spheres"},
    };
    printf("%s: %s %s%s, %uD\n", info->name, table_count(info->n).chars,
           info->rotated ? "rotated " : "", kinds[info->shape][info->n != 1], info->dims);
}

static void print_grid(const duet_scene_info *info, const duet_result *r)
{
    printf("%u x %u", r->cells[0], r->cells[1]);
    if (info->dims == 3)
        printf(" x %u", r->cells[2]);
    printf("%s cells of edge %.6g", r->hashed ? " hashed" : "", (double)r->cell);
    if (r->grid_levels > 1)
        printf(" and coarser, %u grid levels", r->grid_levels);
    if (r->cell_widened)
        printf(", widened from %.6g to hold the largest box", (double)info->cell);
    putchar('\n');
}

static bool is_one(const duet_device_pair *pair, const duet_plan *plan)
{
    return plan->share == 0 && duet_device_pair_is_one(pair);
}

void run_report_devices(const duet_device_pair *pair, const duet_plan *plan)
{
    double share = (double)plan->share / DUET_SHARE_ONE;
    const bool one = is_one(pair, plan);
    table t = table_begin("lllrl");
    for (int i = one; i < 2; ++i) {
        const duet_device_info *d = duet_device_pair_get_info(pair, i);
        table_cell(&t, one ? "on" : "%c", "AB"[i]);
        table_words(&t, d->selector, d->name, NULL);
        table_cell(&t, "%.4g %%", 100 * (i == 0 ? share : 1 - share));
        table_cell(&t, "of the work, kernels '%s'", i == 0 ? plan->variant_a : plan->variant_b);
    }
    table_print(&t, stdout);
}

void run_report_grids(const duet_plan *plan)
{
    if (plan->share > 0 && plan->share < DUET_SHARE_ONE)
        printf("grids: %s\n", duet_mode_name(plan->mode));
}

static void print_source(const run_report *r)
{
    const duet_profile *p = &r->profile;
    if (r->plan_given)
        printf("plan: as given");
    else if (p->grade == DUET_GRADE_STALE)
        printf("plan: the default, since the kernels changed after it was measured");
    else if (p->grade == DUET_GRADE_DEFAULT)
        printf("plan: the default");
    else if (!*p->verdict)
        printf("plan: from the profile of another workload; what it gains here is not known");
    else if (is_one(r->pair, r->plan))
        printf("plan: from the profile, %s", duet_grade_name(p->grade));
    else
        printf("plan: from the profile, %s; %s", duet_grade_name(p->grade),
               say_name(
                   table_gain(p->plan.share, p->gain, p->gain_low, p->gain_high, p->verdict).chars)
                   .chars);
}

static bool is_measured(const run_report *r)
{
    return !r->plan_given && r->profile.grade < DUET_GRADE_STALE;
}

static void print_profile(const run_report *r)
{
    print_source(r);
    if (is_measured(r) || (r->plan_given && !r->accuracy_given)) {
        printf("\n\n");
        return;
    }
    printf("; to measure a better one:\n");
    command_text_print(r->tuning, stdout);
    putchar('\n');
}

// Only a profile knows which level is accurate enough.
static void print_level(const run_report *r)
{
    if (r->accuracy_given && !is_measured(r))
        printf("level: %s, since no profile says that a cheaper one is accurate enough\n",
               r->level);
}

enum { STAGES_MOST = 64 };

// Stages of one name, and the time that each device spent on them.
typedef struct stage_row {
    const char *name;
    double ms[2];
} stage_row;

static uint32_t count_stages(const timed_step *step, int device)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < step->n_stages; ++i)
        n += step->stages[i].device == device;
    return n;
}

static uint32_t add_stages(const timed_step *step, int device, stage_row *rows, uint32_t n)
{
    for (uint32_t i = 0; i < step->n_stages; ++i) {
        const duet_stage *stage = &step->stages[i];
        uint32_t row = 0;
        while (row < n && strcmp(rows[row].name, stage->name) != 0)
            ++row;
        if (stage->device != device || row == STAGES_MOST)
            continue;
        rows[row].name = stage->name;
        rows[row].ms[device] += stage->ms;
        n += row == n;
    }
    return n;
}

static void print_stage(table *t, const stage_row *row, const double all_ms[2])
{
    table_cell(t, "%s", row->name);
    for (int device = 0; device < 2; ++device) {
        if (all_ms[device] <= 0)
            continue;
        double ms = row->ms[device];
        double part = ms > 0 ? ms / all_ms[device] : 0;
        if (ms > 0) {
            table_cell(t, "%.3f", ms);
            table_cell(t, "%.1f", 100 * part);
        } else {
            table_words(t, "-", " ", NULL);
        }
        table_cell(t, "%s", table_bar(part, 16).chars);
    }
}

// In the order of the device that went through more stages, then what only the
// other did. A device that had nothing to do has no columns.
static void print_stages(const timed_step *step, bool one)
{
    stage_row rows[STAGES_MOST] = {{0}};
    double all_ms[2] = {0, 0};
    int fuller = count_stages(step, 1) > count_stages(step, 0);
    uint32_t n = add_stages(step, fuller, rows, 0);
    n = add_stages(step, 1 - fuller, rows, n);
    for (uint32_t i = 0; i < step->n_stages; ++i)
        all_ms[step->stages[i].device == 1] += step->stages[i].ms;
    const bool both = all_ms[0] > 0 && all_ms[1] > 0;
    table t = table_begin(both ? "lrrlrrl" : "lrrl");
    table_words(&t, "", NULL);
    for (int device = 0; device < 2; ++device)
        if (all_ms[device] > 0)
            table_words(&t,
                        one           ? "ms"
                        : device == 0 ? "A ms"
                                      : "B ms",
                        "%", "                ", NULL);
    for (uint32_t i = 0; i < n; ++i)
        print_stage(&t, &rows[i], all_ms);
    table_words(&t, "together", NULL);
    for (int device = 0; device < 2; ++device) {
        if (all_ms[device] <= 0)
            continue;
        table_cell(&t, "%.3f", all_ms[device]);
        table_words(&t, " ", " ", NULL);
    }
    table_print(&t, stdout);
    putchar('\n');
}

static void print_totals(const timed *m, const char *level, bool one)
{
    const duet_result *r = &m->last;
    const timed_step *median = timed_median(m);
    table t = table_begin("lrl");
    table_words(&t, "candidates", table_count(r->candidates).chars, "pairs whose bounds overlap",
                NULL);
    table_words(&t, "pairs", table_count(r->pairs).chars, NULL);
    table_cell(&t, "collide, at level %s; hash %016" PRIx64, level, m->hash);
    if (r->undecided > 0)
        table_words(&t, "undecided", table_count(r->undecided).chars,
                    "too close for float, decided by exact arithmetic on the host", NULL);
    if (r->bad > 0) {
        table_words(&t, "bad objects", table_count(r->bad).chars, NULL);
        table_cell(&t, "left out; the first is %u", r->first_bad);
    }
    table_words(&t, "memory", table_bytes(r->bytes[0] + r->bytes[1]).chars, NULL);
    if (one)
        table_words(&t, "", NULL);
    else
        table_cell(&t, "A %s, B %s", table_bytes(r->bytes[0]).chars,
                   table_bytes(r->bytes[1]).chars);
    table_cell(&t, "time");
    table_cell(&t, "%.3f ms", median->total_ms);
    table_cell(
        &t, "median of %u, %.3f to %.3f; %s boxes a second", m->n, m->steps[0].total_ms,
        m->steps[m->n - 1].total_ms,
        table_rate(median->total_ms > 0 ? (double)r->objects / median->total_ms * 1e3 : 0).chars);
    if (m->cores.disturbed > 0)
        table_words(&t, "", "", table_disturbed(&m->cores).chars, NULL);
    table_print(&t, stdout);
}

void run_report_check(const reference_check *check)
{
    if (reference_check_is_right(check))
        printf("check: the same %s as the plain C reference\n",
               table_things(check->reference, "pair", "pairs").chars);
    else
        printf("check: WRONG: %s of the reference's %s missing, and %s too many\n",
               table_count(check->missing).chars,
               table_things(check->reference, "pair", "pairs").chars,
               table_count(check->extra).chars);
}

// ---------------------------------------------------------------- as JSON

static void add_plan(cJSON *o, const duet_device_pair *pair, const duet_plan *plan)
{
    char both[2 * DUET_VARIANT];
    json_add_pair(o, "pair", pair);
    json_add(o, NUMBER("share", (double)plan->share / DUET_SHARE_ONE),
             STRING("mode", duet_mode_name(plan->mode)));
    bool same = strcmp(plan->variant_a, plan->variant_b) == 0;
    snprintf(both, sizeof both, "%s%s%s", plan->variant_a, same ? "" : ",",
             same ? "" : plan->variant_b);
    json_add(o, STRING("variant", both));
}

static void add_counts(cJSON *o, const duet_scene_info *info, const timed *m)
{
    const duet_result *r = &m->last;
    json_add(o, STRING("scene", info->name), NUMBER("dims", info->dims),
             NUMBER("objects", r->objects), NUMBER("bad", r->bad),
             NUMBER("candidates", r->candidates), NUMBER("pairs", r->pairs),
             NUMBER("undecided", r->undecided));
    json_add_hash(o, m->hash);
    cJSON *cells = cJSON_AddArrayToObject(o, "cells");
    for (uint32_t i = 0; i < info->dims; ++i)
        cJSON_AddItemToArray(cells, cJSON_CreateNumber(r->cells[i]));
    json_add(o, NUMBER("cell", r->cell), NUMBER("grid_levels", r->grid_levels),
             FLAG("hashed", r->hashed), FLAG("cell_widened", r->cell_widened),
             NUMBER("bytes_a", r->bytes[0]), NUMBER("bytes_b", r->bytes[1]));
}

static void add_times(cJSON *o, const timed *m)
{
    const timed_step *median = timed_median(m), *staged = timed_staged(m);
    json_add(o, NUMBER("repeat", m->n));
    json_add_cores(o, &m->cores);
    json_add(o, NUMBER("total_ms", median->total_ms), NUMBER("kernel_ms_a", staged->kernel_ms[0]),
             NUMBER("kernel_ms_b", staged->kernel_ms[1]), NUMBER("least_ms", m->steps[0].total_ms),
             NUMBER("most_ms", m->steps[m->n - 1].total_ms), NUMBER("a_ms", median->device_ms[0]),
             NUMBER("b_ms", median->device_ms[1]));
    json_add_stages(o, staged->stages, staged->n_stages);
}

void run_report_add_check(cJSON *o, const reference_check *check)
{
    cJSON *one = cJSON_AddObjectToObject(o, "check");
    json_add(one, FLAG("right", reference_check_is_right(check)),
             NUMBER("reference", check->reference), NUMBER("missing", check->missing),
             NUMBER("extra", check->extra));
}

// ---------------------------------------------------------------- the whole

static void print_step(const run_report *r)
{
    print_grid(r->scene, &r->timed->last);
    run_report_devices(r->pair, r->plan);
    run_report_grids(r->plan);
    print_level(r);
    print_profile(r);
    print_stages(timed_staged(r->timed), is_one(r->pair, r->plan));
    print_totals(r->timed, r->level, is_one(r->pair, r->plan));
}

void run_report_text(const run_report *r)
{
    run_report_scene(r->scene);
    if (r->scene->n > 0)
        print_step(r);
    if (r->check.asked)
        run_report_check(&r->check);
}

bool run_report_json(const run_report *r, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    add_counts(o, r->scene, r->timed);
    add_plan(o, r->pair, r->plan);
    json_add(o, STRING("level", r->level),
             STRING("profile", r->plan_given ? "given" : duet_grade_name(r->profile.grade)),
             STRING("input", timed_input_name(r->input)), FLAG("ordered", r->ordered));
    add_times(o, r->timed);
    if (r->check.asked)
        run_report_add_check(o, &r->check);
    return say_json(o, err);
}
