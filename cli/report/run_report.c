// SPDX-License-Identifier: MIT
#include "cli/report/run_report.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"

#include <stdio.h>
#include <string.h>

bool reference_check_is_right(const reference_check *check)
{
    return check->missing == 0 && check->extra == 0;
}

void run_report_add_scene(cJSON *o, const duet_scene_info *info, uint64_t objects)
{
    static const char *const kinds[DUET_SHAPES][2] = {
        [DUET_SHAPE_POSES] = {"box", "boxes"},
        [DUET_SHAPE_BOUNDS] = {"axis-aligned box", "axis-aligned boxes"},
        [DUET_SHAPE_ROUNDED_BOXES] = {"rounded box", "rounded boxes"},
        [DUET_SHAPE_SPHERES] = {"sphere", "spheres"},
    };
    char kind[64];
    snprintf(kind, sizeof kind, "%s%s", info->rotated ? "rotated " : "",
             kinds[info->shape][objects != 1]);
    json_add(o, STRING("scene", info->name), STRING("kind", kind), NUMBER("dims", info->dims),
             NUMBER("objects", objects));
}

void run_report_add_plan(cJSON *o, const duet_device_pair *pair, const duet_plan *plan)
{
    json_add_devices(o, pair);
    json_add_plan(o, plan->share / (double)DUET_SHARE_ONE, duet_mode_name(plan->mode),
                  plan->variant_a, plan->variant_b);
}

// "V", or "V,W" of two.
static void add_variants(cJSON *o, const duet_plan *plan)
{
    char both[2 * DUET_VARIANT];
    bool same = strcmp(plan->variant_a, plan->variant_b) == 0;
    snprintf(both, sizeof both, "%s%s%s", plan->variant_a, same ? "" : ",",
             same ? "" : plan->variant_b);
    json_add(o, STRING("variant", both));
}

static void add_counts(cJSON *o, const duet_scene_info *info, const timed *m)
{
    const duet_result *r = &m->last;
    run_report_add_scene(o, info, info->n);
    json_add(o, NUMBER("bad", r->bad), NUMBER("candidates", r->candidates),
             NUMBER("pairs", r->pairs), NUMBER("undecided", r->undecided));
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

// Adds members for the text alone.
static void add_source(cJSON *o, const run_report *r)
{
    const duet_profile *p = &r->profile;
    duet_accuracy accuracy;
    json_add(o, FLAG("plan_given", inputs_plan_given(&r->args->plan)),
             FLAG("accuracy_given", inputs_accuracy_given(&r->args->level, &accuracy)),
             STRING("tuning", text_chars(&r->tuning)), NUMBER("asked_cell", r->scene->cell),
             NUMBER("first_bad", r->timed.last.first_bad),
             INTERVAL("gain", p->gain, p->gain_low, p->gain_high), STRING("verdict", p->verdict));
}

bool run_report_tell(const run_report *r, duet_error *err)
{
    const duet_plan *plan = duet_world_get_plan(r->world);
    const bool is_given = inputs_plan_given(&r->args->plan), json = r->args->json;
    cJSON *o = cJSON_CreateObject();
    add_counts(o, r->scene, &r->timed);
    add_variants(o, plan);
    json_add_pair(o, "pair", r->pair);
    run_report_add_plan(o, r->pair, plan);
    json_add(o, STRING("level", duet_level_get_info(duet_world_get_level(r->world))->name),
             STRING("profile", is_given ? "given" : duet_grade_name(r->profile.grade)),
             STRING("input", timed_input_name(r->input)), FLAG("ordered", r->args->ordered));
    add_times(o, &r->timed);
    if (r->check.asked)
        run_report_add_check(o, &r->check);
    if (!json)
        add_source(o, r);
    return rendering_tell(o, json, "cli/report/run.lua", err);
}
