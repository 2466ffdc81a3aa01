// SPDX-License-Identifier: MIT
#include "cli/report/costs_report.h"

#include "base/error.h"
#include "cli/report/table.h"

#include <inttypes.h>
#include <stdio.h>

static void print_row(table *t, const costs *c, const cost *row)
{
    const duet_effect_info *info = &row->info;
    table_cell(t, "%s", info->name);
    table_cell(t, "%s", info->active ? "yes" : "-");
    table_cell(t, "%s", info->called_by);
    table_cell(t, "%u", info->bytes);
    table_cell(t, "%s", info->active ? info->kernels : "-");
    if (row->measured)
        table_cell(t, "%.3f", row->ms);
    else if (c->steps > 0)
        table_cell(t, "-");
}

void costs_report_text(const costs *c)
{
    static const char *const heads[] = {"effect",          "",        "called for by",
                                        "bytes an object", "kernels", "ms a step"};
    bool measured = c->steps > 0;
    table t = table_begin(measured ? "lllrlr" : "lllrl");
    for (int i = 0; i < 5 + measured; ++i)
        table_cell(&t, "%s", heads[i]);
    for (uint32_t i = 0; i < c->n; ++i)
        print_row(&t, c, &c->rows[i]);
    table_print(&t, stdout);
    if (measured)
        printf("\n%.3f ms a step with all of them, in steps 3 to %" PRIu64 " of the scene\n",
               c->step_ms, c->steps + 2);
}

// ---------------------------------------------------------------- as data

static cJSON *row_json(const cost *row)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "effect", row->info.name);
    cJSON_AddBoolToObject(o, "active", row->info.active);
    cJSON_AddStringToObject(o, "called_by", row->info.called_by);
    cJSON_AddNumberToObject(o, "bytes", row->info.bytes);
    cJSON_AddStringToObject(o, "kernels", row->info.active ? row->info.kernels : "");
    if (row->measured)
        cJSON_AddNumberToObject(o, "ms", row->ms);
    return o;
}

cJSON *costs_report_json(const costs *c, const duet_scene_info *scene, const duet_device_pair *pair)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "type", COSTS_TYPE);
    cJSON_AddStringToObject(o, "scene", scene->name);
    cJSON_AddNumberToObject(o, "objects", scene->n);
    cJSON_AddStringToObject(o, "a", duet_device_pair_get_info(pair, 0)->selector);
    cJSON_AddStringToObject(o, "b", duet_device_pair_get_info(pair, 1)->selector);
    cJSON_AddNumberToObject(o, "steps", (double)c->steps);
    if (c->steps > 0)
        cJSON_AddNumberToObject(o, "step_ms", c->step_ms);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t i = 0; i < c->n; ++i)
        cJSON_AddItemToArray(effects, row_json(&c->rows[i]));
    return o;
}

bool costs_report_check(const cJSON *o, const char *path, duet_error *err)
{
    static const json_field whole[] = {
        {"scene", cJSON_IsString, "a string"},
        {"objects", JSON_COUNT},
        {"effects", cJSON_IsArray, "a list"},
        {0},
    };
    static const json_field row[] = {
        {"effect", cJSON_IsString, "a string"},
        {"called_by", cJSON_IsString, "a string"},
        {"bytes", JSON_COUNT},
        {0},
    };
    bool ok = json_require(o, whole, path, err);
    if (ok && json_number(o, "steps") < 1)
        ok = error_set(err, DUET_STATUS_BAD_INPUT,
                       "%s: no times; 'duet explain --measure' takes them", path);
    return ok && json_require_each(json_list(o, "effects"), row, path, "effect", err);
}
