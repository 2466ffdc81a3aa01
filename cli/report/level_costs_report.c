// SPDX-License-Identifier: MIT
#include "cli/report/level_costs_report.h"

#include "cli/interrupt.h"
#include "cli/say.h"

#include <math.h>

typedef struct watched {
    progress shown;
    const level_costs *costs;
    uint32_t rounds;
} watched;

static bool watch(void *context, const duet_tune_progress *p)
{
    watched *w = context;
    w->shown.total = (uint64_t)w->rounds * w->costs->n;
    progress_show(&w->shown, p->launches);
    return !interrupt_asked();
}

bool level_costs_show(level_costs *p, duet_device_pair *pair, const duet_scene *scene,
                      uint32_t rounds, duet_error *err)
{
    watched w = {progress_begin("step", 0), p, rounds};
    level_costs_def def = {.pair = pair,
                           .scene = scene,
                           .alone = true,
                           .rounds = rounds,
                           .watch = watch,
                           .watch_context = &w};
    bool ok = level_costs_measure(p, &def, err);
    progress_end(&w.shown);
    return ok;
}

static void add_row(cJSON *list, const level_cost *row)
{
    cJSON *o = json_add_row(list);
    const double candidates = (double)row->candidates;
    json_add(o, STRING("level", duet_level_get_info(row->level)->name),
             STRING("device", row->device == 0 ? "A" : "B"), NUMBER("step_ms", row->step_ms),
             NUMBER("relative", row->relative), FLAG("same", row->same),
             NUMBER("relative_low", row->relative_low));
    if (isfinite(row->relative_high))
        json_add(o, NUMBER("relative_high", row->relative_high));
    json_add(o, NUMBER("pairs", row->pairs), NUMBER("missed", row->missed),
             NUMBER("false", row->added), NUMBER("deepest_missed", row->deepest_missed),
             NUMBER("widest_false", row->widest_added),
             NUMBER("undecided_share", candidates > 0 ? (double)row->undecided / candidates : 0),
             FLAG("front", row->front));
}

cJSON *level_costs_report_json(const level_costs *p, const duet_scene_info *scene,
                               const duet_device_pair *pair)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", LEVEL_COSTS_TYPE), STRING("scene", scene->name),
             NUMBER("objects", scene->n), NUMBER("pairs", p->truth));
    json_add_devices(o, pair);
    json_add(o, NUMBER("rounds", p->rounds));
    json_add_cores(o, &p->cores);
    cJSON *levels = cJSON_AddArrayToObject(o, "levels");
    for (uint32_t i = 0; i < p->n; ++i)
        add_row(levels, &p->rows[i]);
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
