// SPDX-License-Identifier: MIT
#include "cli/report/motion_report.h"

#include "cli/report/json.h"
#include "cli/report/run_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

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

// ---------------------------------------------------------------- as text

static const duet_device_pair *pair_of(const motion_report *r)
{
    return duet_motion_get_def(r->motion)->pair;
}

// B does all if no pairs are sought.
static duet_plan plan_used(const motion_report *r)
{
    const duet_plan *of_pairs = duet_motion_get_plan(r->motion);
    duet_plan plan = of_pairs ? *of_pairs : duet_default_plan(pair_of(r));
    plan.share = of_pairs ? plan.share : 0;
    return plan;
}

// A step without pairs, or whose pairs B finds, leaves A idle.
static void tell_plan(const motion_report *r, const duet_plan *plan)
{
    const duet_profile *p = &r->profile;
    bool known = p->grade < DUET_GRADE_STALE;
    printf("plan: ");
    if (r->plan_given)
        printf("as given");
    else if (p->grade == DUET_GRADE_STALE)
        printf("the default, since the kernels changed after it was measured");
    else if (!known)
        printf("the default; 'duet tune --steps' measures a better one");
    else if (p->step_ms > 0)
        printf("from the profile, %s: %.3f ms a step", duet_grade_name(p->grade), p->step_ms);
    else
        printf("from the profile, %s: that of another number of bodies", duet_grade_name(p->grade));
    if (plan->share == 0 && !duet_device_pair_is_one(pair_of(r)))
        printf("; A has nothing to do");
    printf("\n\n");
}

void motion_report_begin(const motion_report *r)
{
    const duet_scene_info *info = r->scene;
    printf("%s: %s, %uD; effects:", info->name, table_things(info->n, "box", "boxes").chars,
           info->dims);
    uint32_t effects = duet_motion_get_effects(r->motion);
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (effects & bit)
            printf(" %s", duet_effect_name(bit));
    const duet_motion_def *def = duet_motion_get_def(r->motion);
    printf("%s\n%s of %.6g s\n", effects ? "" : " none",
           table_things(def->substeps, "substep", "substeps").chars, def->dt / def->substeps);
    duet_plan plan = plan_used(r);
    run_report_devices(pair_of(r), &plan);
    run_report_grids(&plan);
    tell_plan(r, &plan);
    printf("%9s %9s %12s %12s %12s %12s %12s %9s\n", "step", "time", "kinetic", "potential",
           "energy", "pairs", "contacts", "ms");
}

bool motion_report_row(const motion_report *r, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    printf("%9" PRIu64 " %9.3f %12.5g %12.5g %12.5g %12" PRIu64 " %12" PRIu64 " %9.2f\n", r->done,
           r->last.time, e.kinetic + e.turning, e.potential, e.kinetic + e.turning + e.potential,
           r->last.pairs, r->last.contacts, r->last.total_ms);
    fflush(stdout);
    return true;
}

static double mean_ms(const motion_report *r)
{
    return r->done > 1 ? r->total_ms / (double)(r->done - 1) : 0.0;
}

static void tell_stage(table *t, const char *name, double ms, double whole)
{
    double part = whole > 0 ? ms / whole : 0.0;
    table_cell(t, "%s", name);
    table_cell(t, "%.3f", ms);
    table_cell(t, "%.1f", 100 * part);
    table_cell(t, "%s", table_bar(part, 24).chars);
}

// The rest of a step is the host's own work and waits. Stages of two devices may take more
// together than the step does.
static void tell_times(const motion_report *r)
{
    table t = table_begin("lrrl");
    double mean = mean_ms(r), all = 0;
    for (uint32_t i = 0; i < r->n_stages; ++i)
        all += r->stages[i].ms / (double)r->staged_steps;
    double whole = fmax(mean, all);
    table_words(&t, "", "ms a step", "%", "", NULL);
    for (uint32_t i = 0; i < r->n_stages; ++i)
        tell_stage(&t, r->stages[i].name, r->stages[i].ms / (double)r->staged_steps, whole);
    if (all < mean)
        tell_stage(&t, "host and waits", mean - all, whole);
    table_print(&t, stdout);
    if (r->timed_steps + 1 < r->done)
        printf("of %s\n", table_things(r->timed_steps, "timed step", "timed steps").chars);
    printf("\n%.3f ms a step after the first, the slowest %.3f: %.4g steps a second\n", mean,
           r->slowest_ms, mean > 0 ? 1e3 / mean : 0.0);
}

void motion_report_end(const motion_report *r, uint64_t hash)
{
    putchar('\n');
    if (r->n_stages > 0)
        tell_times(r);
    else if (duet_motion_get_effects(r->motion) == 0)
        printf("nothing is called for, so that a step launches nothing\n");
    printf("state hash %016" PRIx64 "\n", hash);
}

// ---------------------------------------------------------------- as JSON

bool motion_report_json(const motion_report *r, uint64_t hash, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", r->scene->name),
             NUMBER("objects", duet_motion_get_count(r->motion)));
    duet_plan plan = plan_used(r);
    json_add_plan(o, plan.share / (double)DUET_SHARE_ONE, duet_mode_name(plan.mode), plan.variant_a,
                  plan.variant_b);
    json_add(o, STRING("profile", r->plan_given ? "given" : duet_grade_name(r->profile.grade)),
             NUMBER("steps", r->done), NUMBER("time", r->last.time),
             NUMBER("ms_a_step", mean_ms(r)), NUMBER("pairs", r->last.pairs),
             NUMBER("contacts", r->last.contacts), NUMBER("kinetic", e.kinetic + e.turning),
             NUMBER("potential", e.potential));
    json_add_hash(o, hash);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (duet_motion_get_effects(r->motion) & bit)
            cJSON_AddItemToArray(effects, cJSON_CreateString(duet_effect_name(bit)));
    cJSON *stages = cJSON_AddObjectToObject(o, "stages_ms");
    for (uint32_t i = 0; i < r->n_stages; ++i)
        json_add(stages, NUMBER(r->stages[i].name, r->stages[i].ms / (double)r->staged_steps));
    json_add(o, NUMBER("timed_steps", r->timed_steps));
    return say_json(o, err);
}
