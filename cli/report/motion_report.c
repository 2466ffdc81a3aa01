// SPDX-License-Identifier: MIT
#include "cli/report/motion_report.h"

#include "cli/inputs.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/report/run_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// ---------------------------------------------------------------- what steps took

// Each timed step stands for those since the one before.
static void add_stage(motion_report *r, const duet_stage *stage)
{
    uint32_t i = 0;
    while (i < r->n_stages && strcmp(r->stages[i].name, stage->name) != 0)
        ++i;
    if (i == MOTION_REPORT_STAGES)
        return;
    if (i == r->n_stages)
        snprintf(r->stages[r->n_stages++].name, sizeof r->stages[0].name, "%s", stage->name);
    r->stages[i].ms += stage->ms * (double)r->since_timed;
}

static void add_stages(motion_report *r)
{
    ++r->since_timed;
    if (!r->last.timed)
        return;
    for (uint32_t i = 0; i < r->last.n_stages; ++i)
        add_stage(r, &r->last.stages[i]);
    r->staged_steps += r->since_timed;
    r->since_timed = 0;
    ++r->timed_steps;
}

void motion_report_add(motion_report *r, const duet_motion_result *step)
{
    r->last = *step;
    if (++r->done == 1)
        return;
    r->total_ms += step->total_ms;
    r->slowest_ms = fmax(r->slowest_ms, step->total_ms);
    add_stages(r);
}

// ---------------------------------------------------------------- what is told

static void add_effects(cJSON *o, const motion_report *r)
{
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (duet_motion_get_effects(r->motion) & bit)
            cJSON_AddItemToArray(effects, cJSON_CreateString(duet_effect_name(bit)));
}

// The scene, the plan, and where that is from.
static cJSON *describe(const motion_report *r, uint64_t n)
{
    cJSON *o = cJSON_CreateObject();
    const duet_plan plan = inputs_motion_plan(r->motion);
    json_add(o, STRING("scene", r->scene->name), NUMBER("objects", n));
    run_report_add_plan(o, duet_motion_get_def(r->motion)->pair, &plan);
    json_add(o, STRING("profile", r->plan_given ? "given" : duet_grade_name(r->profile.grade)));
    add_effects(o, r);
    return o;
}

bool motion_report_begin(const motion_report *r, duet_error *err)
{
    const duet_motion_def *def = duet_motion_get_def(r->motion);
    cJSON *o = describe(r, r->scene->n);
    json_add(o, NUMBER("dims", r->scene->dims), NUMBER("substeps", def->substeps),
             NUMBER("dt", def->dt), NUMBER("step_ms", r->profile.step_ms),
             STRING("tuning", text_chars(&r->tuning)));
    bool ok = rendering_tell(o, false, "cli/report/motion_begin.lua", err);
    printf("%9s %9s %12s %12s %12s %12s %12s %9s\n", "step", "time", "kinetic", "potential",
           "energy", "pairs", "contacts", "ms");
    return ok;
}

bool motion_report_row(const motion_report *r, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    printf("%9" PRIu64 " %9.3f %12.5g %12.5g %12.5g %12" PRIu64 " %12" PRIu64 " %9.2f\n",
           r->last.step, r->last.time, e.kinetic + e.turning, e.potential,
           e.kinetic + e.turning + e.potential, r->last.pairs, r->last.contacts, r->last.total_ms);
    fflush(stdout);
    return true;
}

static double mean_ms(const motion_report *r)
{
    return r->done > 1 ? r->total_ms / (double)(r->done - 1) : 0.0;
}

static void add_stage_times(cJSON *o, const motion_report *r, bool json)
{
    cJSON *stages = json ? cJSON_AddObjectToObject(o, "stages_ms") : NULL;
    cJSON *rows = json ? NULL : cJSON_AddArrayToObject(o, "stages");
    for (uint32_t i = 0; i < r->n_stages; ++i) {
        double ms = r->stages[i].ms / (double)r->staged_steps;
        if (json)
            json_add(stages, NUMBER(r->stages[i].name, ms));
        else
            json_add(json_add_row(rows), STRING("name", r->stages[i].name), NUMBER("ms", ms));
    }
}

bool motion_report_end(const motion_report *r, uint64_t hash, bool json, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    cJSON *o = describe(r, duet_motion_get_count(r->motion));
    json_add(o, NUMBER("step", duet_motion_get_step(r->motion)), NUMBER("steps", r->done),
             NUMBER("time", r->last.time), NUMBER("ms_a_step", mean_ms(r)),
             NUMBER("slowest_ms", r->slowest_ms), NUMBER("pairs", r->last.pairs),
             NUMBER("contacts", r->last.contacts), NUMBER("kinetic", e.kinetic + e.turning),
             NUMBER("potential", e.potential));
    json_add_hash(o, hash);
    add_stage_times(o, r, json);
    json_add(o, NUMBER("timed_steps", r->timed_steps));
    return rendering_tell(o, json, "cli/report/motion_end.lua", err);
}
