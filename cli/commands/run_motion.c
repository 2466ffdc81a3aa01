// SPDX-License-Identifier: MIT
#include "cli/commands/run.h"

#include "base/error.h"
#include "cli/frames.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/run_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// A run of so few steps is timed by stages, though a GPU then takes longer.
enum { FEW_STEPS = 64 };
enum { STAGES_MOST = 32, ROWS_TOLD = 10 };

// A run, and what it took by effect.
typedef struct moved {
    const arguments *args;
    const duet_scene *scene;
    duet_motion_def def;
    duet_motion *motion;
    duet_profile profile; // that it goes by
    duet_replay *replay;  // NULL: no recorded commands
    duet_motion_result last;
    snapshot look;
    frames frames;
    progress shown;
    uint64_t done;
    double total_ms;
    double slowest_ms;
    uint64_t since_timed;  // steps, of those after the first
    uint64_t staged_steps; // up to the last timed one
    uint64_t timed_steps;
    struct {
        char name[24];
        double ms;
    } stages[STAGES_MOST];
    uint32_t n_stages;
} moved;

// Each timed step stands for those since the one before.
static void add_stage(moved *r, const duet_stage *stage)
{
    uint32_t i = 0;
    while (i < r->n_stages && strcmp(r->stages[i].name, stage->name) != 0)
        ++i;
    if (i == STAGES_MOST)
        return;
    if (i == r->n_stages)
        snprintf(r->stages[r->n_stages++].name, sizeof r->stages[0].name, "%s", stage->name);
    r->stages[i].ms += stage->ms * (double)r->since_timed;
}

static void add_stages(moved *r)
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

static double time_of(const moved *r)
{
    return (double)r->done * r->def.dt;
}

static bool draw_picture(moved *r, duet_error *err)
{
    return !r->args->picture ||
           snapshot_picture(&r->look, r->args->picture, r->motion, time_of(r), err);
}

static bool begin_frames(moved *r, duet_error *err)
{
    frames_format format = FRAMES_PNG;
    frames_format_named(r->args->format, &format); // which it is: run.c looked
    return frames_begin(&r->frames, r->args->frames, format, r->motion, &r->look, err) &&
           frames_add(&r->frames, time_of(r), err);
}

static bool tell_step(moved *r, duet_error *err)
{
    duet_energy e;
    uint64_t every = r->args->steps / ROWS_TOLD;
    bool due = r->done == 1 || r->done == r->args->steps || (every > 0 && r->done % every == 0);
    if (!due || r->args->json)
        return true;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    progress_hide(&r->shown);
    printf("%9" PRIu64 " %9.3f %12.5g %12.5g %12.5g %12" PRIu64 " %12" PRIu64 " %9.2f\n", r->done,
           r->last.time, e.kinetic + e.turning, e.potential, e.kinetic + e.turning + e.potential,
           r->last.pairs, r->last.contacts, r->last.total_ms);
    fflush(stdout);
    return true;
}

static bool step(moved *r, duet_error *err)
{
    if (!(r->replay ? duet_replay_advance(r->replay, r->motion, &r->last, err)
                    : duet_motion_advance(r->motion, &r->last, err)))
        return false;
    ++r->done;
    if (r->done > 1) { // the first builds kernels and makes space
        r->total_ms += r->last.total_ms;
        r->slowest_ms = fmax(r->slowest_ms, r->last.total_ms);
        add_stages(r);
    }
    return tell_step(r, err) && frames_add(&r->frames, time_of(r), err);
}

// B does all if no pairs are sought.
static duet_plan plan_used(const moved *r)
{
    const duet_plan *of_pairs = duet_motion_get_plan(r->motion);
    duet_plan plan = of_pairs ? *of_pairs : duet_default_plan(r->def.pair);
    plan.share = of_pairs ? plan.share : 0;
    return plan;
}

// A step without pairs, or whose pairs B finds, leaves A idle.
static void tell_plan(const moved *r, const duet_plan *plan)
{
    const duet_profile *p = &r->profile;
    bool given = inputs_plan_given(&r->args->plan), known = p->grade < DUET_GRADE_STALE;
    printf("plan: ");
    if (given)
        printf("as given");
    else if (p->grade == DUET_GRADE_STALE)
        printf("the default, since the kernels changed after it was measured");
    else if (!known)
        printf("the default; 'duet tune --steps' measures a better one");
    else if (p->step_ms > 0)
        printf("from the profile, %s: %.3f ms a step", duet_grade_name(p->grade), p->step_ms);
    else
        printf("from the profile, %s: that of another number of bodies", duet_grade_name(p->grade));
    if (plan->share == 0 && !duet_device_pair_is_one(r->def.pair))
        printf("; A has nothing to do");
    printf("\n\n");
}

static void tell_begin(const moved *r)
{
    const duet_scene_info *info = duet_scene_get_info(r->scene);
    if (r->args->json)
        return;
    printf("%s: %s, %uD; effects:", info->name, table_things(info->n, "box", "boxes").chars,
           info->dims);
    uint32_t effects = duet_motion_get_effects(r->motion);
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (effects & bit)
            printf(" %s", duet_effect_name(bit));
    uint32_t substeps = duet_motion_get_def(r->motion)->substeps;
    printf("%s\n%s of %.6g s\n", effects ? "" : " none",
           table_things(substeps, "substep", "substeps").chars, r->def.dt / substeps);
    duet_plan plan = plan_used(r);
    run_report_devices(r->def.pair, &plan);
    run_report_grids(&plan);
    tell_plan(r, &plan);
    printf("%9s %9s %12s %12s %12s %12s %12s %9s\n", "step", "time", "kinetic", "potential",
           "energy", "pairs", "contacts", "ms");
}

static double mean_ms(const moved *r)
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
static void tell_times(const moved *r)
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

static void tell_end(const moved *r, uint64_t hash)
{
    putchar('\n');
    if (r->n_stages > 0)
        tell_times(r);
    else if (duet_motion_get_effects(r->motion) == 0)
        printf("nothing is called for, so that a step launches nothing\n");
    printf("state hash %016" PRIx64 "\n", hash);
}

static bool tell_json(moved *r, uint64_t hash, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "scene", duet_scene_get_info(r->scene)->name);
    cJSON_AddNumberToObject(o, "objects", duet_motion_get_count(r->motion));
    duet_plan plan = plan_used(r);
    json_add_plan(o, plan.share / (double)DUET_SHARE_ONE, duet_mode_name(plan.mode), plan.variant_a,
                  plan.variant_b);
    cJSON_AddStringToObject(o, "profile",
                            inputs_plan_given(&r->args->plan) ? "given"
                                                              : duet_grade_name(r->profile.grade));
    cJSON_AddNumberToObject(o, "steps", (double)r->done);
    cJSON_AddNumberToObject(o, "time", r->last.time);
    cJSON_AddNumberToObject(o, "ms_a_step", mean_ms(r));
    cJSON_AddNumberToObject(o, "pairs", (double)r->last.pairs);
    cJSON_AddNumberToObject(o, "contacts", (double)r->last.contacts);
    cJSON_AddNumberToObject(o, "kinetic", e.kinetic + e.turning);
    cJSON_AddNumberToObject(o, "potential", e.potential);
    json_add_hash(o, hash);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (duet_motion_get_effects(r->motion) & bit)
            cJSON_AddItemToArray(effects, cJSON_CreateString(duet_effect_name(bit)));
    cJSON *stages = cJSON_AddObjectToObject(o, "stages_ms");
    for (uint32_t i = 0; i < r->n_stages; ++i)
        cJSON_AddNumberToObject(stages, r->stages[i].name,
                                r->stages[i].ms / (double)r->staged_steps);
    cJSON_AddNumberToObject(o, "timed_steps", (double)r->timed_steps);
    return say_json(o, err);
}

// As choose_plan; a motion in which nothing happens has no plan.
static void choose_motion_plan(moved *r)
{
    duet_error failure = {0};
    bool happens = duet_motion_get_count(r->motion) > 0 && duet_motion_get_effects(r->motion) != 0;
    r->profile.grade = DUET_GRADE_DEFAULT;
    if (happens && !inputs_plan_given(&r->args->plan) &&
        !duet_motion_load_profile(r->motion, NULL, &r->profile, &failure))
        say_failed(&failure);
}

static bool open_motion(moved *r, duet_device_pair *pair, duet_error *err)
{
    r->def = duet_scene_motion_def(r->scene, pair);
    r->def.stage_times = r->args->steps <= FEW_STEPS;
    if (!inputs_change_plan(&r->args->plan, pair, r->args->pair, &r->def.plan, err))
        return false;
    r->motion = duet_motion_create_from_scene(&r->def, r->scene, NULL, err);
    if (r->motion)
        choose_motion_plan(r);
    return r->motion && snapshot_begin(&r->look, &r->def, r->scene, r->motion, err);
}

static bool open_replay(moved *r, duet_error *err)
{
    if (!r->args->replay)
        return true;
    r->replay = duet_replay_create(r->args->replay, err);
    uint64_t recorded = duet_replay_get_info(r->replay).steps;
    return r->replay && (r->args->steps <= recorded ||
                         error_set(err, DUET_STATUS_BAD_ARGUMENT,
                                   "--steps %" PRIu64 ": %s has %" PRIu64 " recorded steps",
                                   r->args->steps, r->args->replay, recorded));
}

static bool save_recording(moved *r, duet_error *err)
{
    return !r->args->record || duet_motion_save_recording(r->motion, r->args->record, err);
}

static bool run_steps(moved *r, duet_error *err)
{
    // The picture is drawn at the start too: where it cannot be written, that is told at once.
    bool ok = begin_frames(r, err) && draw_picture(r, err);
    r->shown = progress_begin("step", r->args->steps);
    while (ok && r->done < r->args->steps && !interrupt_asked()) {
        ok = step(r, err);
        progress_show(&r->shown, r->done);
    }
    progress_end(&r->shown);
    uint64_t hash = 0;
    ok = ok && duet_motion_get_hash(r->motion, &hash, err) && draw_picture(r, err) &&
         save_recording(r, err);
    if (ok && r->args->json)
        return tell_json(r, hash, err);
    if (ok)
        tell_end(r, hash);
    return ok && interrupt_check(err);
}

bool run_motion(const arguments *args, const duet_scene *scene, duet_device_pair *pair,
                duet_error *err)
{
    moved r = {.args = args, .scene = scene};
    bool ok = open_motion(&r, pair, err) && open_replay(&r, err) &&
              (!args->record || duet_motion_record(r.motion, err));
    if (ok)
        tell_begin(&r);
    ok = ok && run_steps(&r, err);
    frames_end(&r.frames);
    snapshot_end(&r.look);
    duet_replay_destroy(r.replay);
    duet_motion_destroy(r.motion);
    return ok;
}
