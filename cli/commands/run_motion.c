// SPDX-License-Identifier: MIT
#include "cli/commands/run_motion.h"

#include "base/error.h"
#include "cli/draw/snapshot.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { STAGES_MOST = 32, ROWS_TOLD = 10, FRAMES_A_SECOND = 30 };

// A run, and what it took by effect.
typedef struct moved {
    const run_motion_options *options;
    const duet_scene *scene;
    duet_motion_def def;
    duet_motion *motion;
    duet_motion_result last;
    duet_state *states;
    snapshot look;
    uint64_t done;
    uint64_t frames;
    double total_ms;
    double slowest_ms;
    struct {
        char name[24];
        double ms;
    } stages[STAGES_MOST];
    uint32_t n_stages;
} moved;

static void add_stage(moved *r, const duet_stage *stage)
{
    uint32_t i = 0;
    while (i < r->n_stages && strcmp(r->stages[i].name, stage->name) != 0)
        ++i;
    if (i == STAGES_MOST)
        return;
    if (i == r->n_stages)
        snprintf(r->stages[r->n_stages++].name, sizeof r->stages[0].name, "%s", stage->name);
    r->stages[i].ms += stage->ms;
}

// A frame where its time has come.
static bool draw_frame(moved *r, duet_error *err)
{
    double time = (double)r->done * r->def.dt;
    if (!r->options->frames || time * FRAMES_A_SECOND < (double)r->frames)
        return true;
    char path[4096];
    int n = snprintf(path, sizeof path, "%s/%05" PRIu64 ".png", r->options->frames, r->frames++);
    if (n < 0 || (size_t)n >= sizeof path)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "--frames: the folder's name is too long");
    return duet_motion_get_states(r->motion, r->states, err) &&
           snapshot_frame(&r->look, path, r->states, err);
}

static bool draw_picture(moved *r, duet_error *err)
{
    return !r->options->picture ||
           (duet_motion_get_states(r->motion, r->states, err) &&
            snapshot_picture(&r->look, r->options->picture, r->states, err));
}

static bool make_folder(const char *path, duet_error *err)
{
    return !path || mkdir(path, 0777) == 0 || errno == EEXIST ||
           error_set(err, DUET_STATUS_IO_FAILED, "--frames: the folder %s cannot be made: %s", path,
                     strerror(errno));
}

static bool tell_step(moved *r, duet_error *err)
{
    duet_energy e;
    uint64_t every = r->options->steps / ROWS_TOLD;
    bool due = r->done == 1 || r->done == r->options->steps || (every > 0 && r->done % every == 0);
    if (!due || r->options->json)
        return true;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    printf("%9" PRIu64 " %9.3f %12.5g %12.5g %12.5g %12" PRIu64 " %12" PRIu64 " %9.2f\n", r->done,
           r->last.time, e.kinetic + e.turning, e.potential, e.kinetic + e.turning + e.potential,
           r->last.pairs, r->last.contacts, r->last.total_ms);
    fflush(stdout);
    return true;
}

static bool step(moved *r, duet_error *err)
{
    if (!duet_motion_advance(r->motion, &r->last, err))
        return false;
    ++r->done;
    if (r->done > 1) { // the first builds kernels and makes space
        r->total_ms += r->last.total_ms;
        r->slowest_ms = fmax(r->slowest_ms, r->last.total_ms);
        for (uint32_t i = 0; i < r->last.n_stages; ++i)
            add_stage(r, &r->last.stages[i]);
    }
    return tell_step(r, err) && draw_frame(r, err);
}

// ---------------------------------------------------------------- telling

static void tell_begin(const moved *r)
{
    const duet_scene_info *info = duet_scene_get_info(r->scene);
    if (r->options->json)
        return;
    printf("%s: %s boxes, %uD; effects:", info->name, table_count(info->n).chars, info->dims);
    uint32_t effects = duet_motion_get_effects(r->motion);
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (effects & bit)
            printf(" %s", duet_effect_name(bit));
    printf("%s\n%u substeps of %.6g s\n\n", effects ? "" : " none", r->def.substeps,
           r->def.dt / r->def.substeps);
    printf("%9s %9s %12s %12s %12s %12s %12s %9s\n", "step", "time", "kinetic", "potential",
           "energy", "pairs", "contacts", "ms");
}

static double mean_ms(const moved *r)
{
    return r->done > 1 ? r->total_ms / (double)(r->done - 1) : 0.0;
}

static void tell_times(const moved *r)
{
    table t = table_begin("lrrl");
    static const char *const heads[] = {"", "ms a step", "%", ""};
    double mean = mean_ms(r);
    for (int i = 0; i < 4; ++i)
        table_cell(&t, "%s", heads[i]);
    for (uint32_t i = 0; i < r->n_stages && r->done > 1; ++i) {
        double ms = r->stages[i].ms / (double)(r->done - 1);
        table_cell(&t, "%s", r->stages[i].name);
        table_cell(&t, "%.3f", ms);
        table_cell(&t, "%.1f", mean > 0 ? 100 * ms / mean : 0.0);
        table_cell(&t, "%s", table_bar(mean > 0 ? ms / mean : 0.0, 24).chars);
    }
    table_print(&t, stdout);
    printf("\n%.3f ms a step, the slowest %.3f: %.4g steps a second\n", mean, r->slowest_ms,
           mean > 0 ? 1e3 / mean : 0.0);
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
    char digits[17];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "scene", duet_scene_get_info(r->scene)->name);
    cJSON_AddNumberToObject(o, "objects", duet_motion_get_count(r->motion));
    cJSON_AddNumberToObject(o, "steps", (double)r->done);
    cJSON_AddNumberToObject(o, "time", r->last.time);
    cJSON_AddNumberToObject(o, "ms_a_step", mean_ms(r));
    cJSON_AddNumberToObject(o, "pairs", (double)r->last.pairs);
    cJSON_AddNumberToObject(o, "contacts", (double)r->last.contacts);
    cJSON_AddNumberToObject(o, "kinetic", e.kinetic + e.turning);
    cJSON_AddNumberToObject(o, "potential", e.potential);
    cJSON_AddStringToObject(o, "hash", digits);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (duet_motion_get_effects(r->motion) & bit)
            cJSON_AddItemToArray(effects, cJSON_CreateString(duet_effect_name(bit)));
    cJSON *stages = cJSON_AddObjectToObject(o, "stages_ms");
    for (uint32_t i = 0; i < r->n_stages && r->done > 1; ++i)
        cJSON_AddNumberToObject(stages, r->stages[i].name, r->stages[i].ms / (double)(r->done - 1));
    return say_json(o, err);
}

// ---------------------------------------------------------------- the run

static bool open(moved *r, duet_device_pair *pair, const plan_options *plan, duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(r->scene);
    r->def = duet_scene_motion_def(r->scene, pair);
    if (!inputs_change_plan(plan, &r->def.plan, err))
        return false;
    r->motion = duet_motion_create_from_scene(&r->def, r->scene, NULL, err);
    r->states = calloc((size_t)info->n + 1, sizeof *r->states);
    if (r->motion && !r->states)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%u states: no memory", info->n);
    if (!r->motion || !duet_motion_get_states(r->motion, r->states, err))
        return false;
    return snapshot_begin(&r->look, &r->def, r->scene, r->states, err);
}

static bool run(moved *r, duet_error *err)
{
    // The picture is drawn at the start too: where it cannot be written, that is told at once.
    bool ok = make_folder(r->options->frames, err) && draw_frame(r, err) && draw_picture(r, err);
    progress p = progress_begin("step", r->options->steps);
    while (ok && r->done < r->options->steps && !interrupt_asked()) {
        ok = step(r, err);
        progress_show(&p, r->done);
    }
    progress_end(&p);
    uint64_t hash = 0;
    ok = ok && duet_motion_get_hash(r->motion, &hash, err) && draw_picture(r, err);
    if (ok && r->options->json)
        return tell_json(r, hash, err);
    if (ok)
        tell_end(r, hash);
    return ok && interrupt_check(err);
}

bool run_motion(const run_motion_options *options, const duet_scene *scene, duet_device_pair *pair,
                const plan_options *plan, duet_error *err)
{
    moved r = {.options = options, .scene = scene};
    bool ok = open(&r, pair, plan, err);
    if (ok)
        tell_begin(&r);
    ok = ok && run(&r, err);
    snapshot_end(&r.look);
    duet_motion_destroy(r.motion);
    free(r.states);
    return ok;
}
