// SPDX-License-Identifier: MIT
#include "cli/report/level_costs_report.h"

#include "base/text.h"
#include "cli/report/table.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

enum { BAR = 20 };

static const char *name_of(const level_cost *row)
{
    return duet_level_get_info(row->level)->name;
}

static double undecided_share(const level_cost *row)
{
    return row->candidates ? (double)row->undecided / (double)row->candidates : 0;
}

// ---------------------------------------------------------------- as text

static double slowest_ms(const level_costs *p, int device)
{
    double ms = 0;
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].device == device)
            ms = fmax(ms, p->rows[i].step_ms);
    return ms;
}

static void distance_cell(table *t, uint64_t n, double distance)
{
    if (n == 0)
        table_cell(t, "-");
    else
        table_cell(t, "%.2g", distance);
}

static void print_row(table *t, const level_cost *row, double slowest)
{
    table_cell(t, "%s", row->front ? "*" : " ");
    table_cell(t, "%s", name_of(row));
    table_cell(t, "%.3f", row->step_ms);
    table_cell(t, "%.2f", row->relative);
    table_cell(t, "%s", table_bar(row->step_ms / slowest, BAR).chars);
    table_cell(t, "%s", table_count(row->missed).chars);
    table_cell(t, "%s", table_count(row->added).chars);
    distance_cell(t, row->missed, row->deepest_missed);
    distance_cell(t, row->added, row->widest_added);
    table_cell(t, "%.2g %%", 100 * undecided_share(row));
}

static void print_device(const level_costs_report *r, int device)
{
    static const char *const heads[] = {" ",      "level", "ms a step", "/ sat15", " ",
                                        "missed", "false", "deepest",   "widest",  "undecided"};
    const duet_device_info *info = duet_device_pair_get_info(r->pair, device);
    printf("\n%c %s, %s, alone\n", "AB"[device], info->selector, info->name);
    table t = table_begin("llrrlrrrrr");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i)
        table_cell(&t, "%s", heads[i]);
    double slowest = slowest_ms(r->costs, device);
    for (uint32_t i = 0; i < r->costs->n; ++i)
        if (r->costs->rows[i].device == device)
            print_row(&t, &r->costs->rows[i], slowest);
    table_print(&t, stdout);
}

void level_costs_report_text(const level_costs_report *r)
{
    printf("%s: %s objects, ", r->scene->name, table_count(r->scene->n).chars);
    printf("%s pairs collide; median of %u steps\n", table_count(r->costs->truth).chars,
           r->costs->rounds);
    print_device(r, 0);
    print_device(r, 1);
    printf("\n* nothing is both faster and more right. missed: pairs that collide; false: that do "
           "not.\ndeepest: overlap of the worst missed; widest: separation of the worst false one, "
           "in the "
           "scene's unit.\n");
}

// ---------------------------------------------------------------- as data

static cJSON *row_json(const level_cost *row)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "level", name_of(row));
    cJSON_AddStringToObject(o, "device", row->device == 0 ? "A" : "B");
    cJSON_AddNumberToObject(o, "step_ms", row->step_ms);
    cJSON_AddNumberToObject(o, "relative", row->relative);
    cJSON_AddNumberToObject(o, "pairs", (double)row->pairs);
    cJSON_AddNumberToObject(o, "missed", (double)row->missed);
    cJSON_AddNumberToObject(o, "false", (double)row->added);
    cJSON_AddNumberToObject(o, "deepest_missed", row->deepest_missed);
    cJSON_AddNumberToObject(o, "widest_false", row->widest_added);
    cJSON_AddNumberToObject(o, "undecided_share", undecided_share(row));
    cJSON_AddBoolToObject(o, "front", row->front);
    return o;
}

cJSON *level_costs_report_json(const level_costs_report *r)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "type", LEVEL_COSTS_TYPE);
    cJSON_AddStringToObject(o, "scene", r->scene->name);
    cJSON_AddNumberToObject(o, "objects", r->scene->n);
    cJSON_AddNumberToObject(o, "pairs", (double)r->costs->truth);
    cJSON_AddStringToObject(o, "a", duet_device_pair_get_info(r->pair, 0)->selector);
    cJSON_AddStringToObject(o, "b", duet_device_pair_get_info(r->pair, 1)->selector);
    cJSON_AddNumberToObject(o, "rounds", r->costs->rounds);
    cJSON *levels = cJSON_AddArrayToObject(o, "levels");
    for (uint32_t i = 0; i < r->costs->n; ++i)
        cJSON_AddItemToArray(levels, row_json(&r->costs->rows[i]));
    return o;
}

bool level_costs_report_check(const cJSON *o, const char *path, duet_error *err)
{
    static const json_field whole[] = {
        {"scene", cJSON_IsString, "a string"},
        {"objects", JSON_COUNT},
        {"pairs", JSON_COUNT},
        {"a", cJSON_IsString, "a string"},
        {"b", cJSON_IsString, "a string"},
        {"levels", cJSON_IsArray, "a list"},
        {0},
    };
    static const json_field row[] = {
        {"level", cJSON_IsString, "a string"},
        {"device", cJSON_IsString, "a string"},
        {"step_ms", JSON_AMOUNT},
        {"relative", JSON_AMOUNT},
        {"missed", JSON_COUNT},
        {"false", JSON_COUNT},
        {0},
    };
    return json_require(o, whole, path, err) &&
           json_require_each(json_list(o, "levels"), row, path, "level", err);
}

bool level_costs_report_csv(const level_costs_report *r, const char *path, duet_error *err)
{
    text lines = {0};
    text_add(&lines, "device,level,step_ms,relative,pairs,missed,false,deepest_missed,"
                     "widest_false,undecided_share,front\n");
    for (uint32_t i = 0; i < r->costs->n; ++i) {
        const level_cost *row = &r->costs->rows[i];
        text_add(&lines, "%s,%s,%.9g,%.9g,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%.9g,%.9g,%.9g,%d\n",
                 duet_device_pair_get_info(r->pair, row->device)->selector, name_of(row),
                 row->step_ms, row->relative, row->pairs, row->missed, row->added,
                 row->deepest_missed, row->widest_added, undecided_share(row), row->front);
    }
    bool ok = text_ok(&lines, err) && text_write_file(path, text_chars(&lines), lines.length, err);
    text_free(&lines);
    return ok;
}
