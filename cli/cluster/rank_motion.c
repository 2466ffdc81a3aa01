// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_motion.h"

#include "cli/cluster/rank_frames.h"

#include "base/budget.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"

#include <stdio.h>

typedef struct moved {
    duet_cluster *cluster;
    const cluster_arguments *args;
    const char *scene;
    rank_frames frames;
    duet_cluster_motion_result last;
    double all_ms;
    uint64_t n_steps; // of this run, which may go on from a checkpoint
    uint64_t hash;
    bool is_stopped;
} moved;

static bool begin(const moved *r, duet_error *err)
{
    scene_settings settings;
    bool ok = inputs_make_settings(&settings, &r->args->scene, err);
    ok = ranks_agree(&r->cluster->ranks, ok, err) &&
         duet_cluster_begin_motion(r->cluster, r->scene, settings.list, settings.n, r->args->resume,
                                   err);
    inputs_free_settings(&settings);
    return ok;
}

// After so many steps, and after the last one.
static bool save(const moved *r, bool is_last, duet_error *err)
{
    uint64_t every = r->args->every;
    bool due = is_last || (every > 0 && r->last.step % every == 0);
    return !r->args->checkpoint || !due ||
           duet_cluster_save_motion(r->cluster, r->args->checkpoint, err);
}

// A rank that is asked to stop stops all.
static bool run_steps(moved *r, duet_error *err)
{
    bool ok, tells = duet_cluster_get_rank(r->cluster) == 0;
    progress p = progress_begin("step", r->args->steps);
    ok = rank_frames_add(&r->frames, 0, err);
    for (uint64_t i = 0; ok && !r->is_stopped && i < r->args->steps; ++i) {
        ok = duet_cluster_advance(r->cluster, &r->last, err);
        r->all_ms += r->last.total_ms;
        ++r->n_steps;
        uint64_t stops = ok && !budget_check_stop(NULL);
        if (ok)
            ranks_sum(&r->cluster->ranks, &stops, 1);
        r->is_stopped = stops > 0;
        ok = ok && rank_frames_add(&r->frames, r->last.step, err) &&
             save(r, r->is_stopped || i + 1 == r->args->steps, err);
        if (tells)
            progress_show(&p, i + 1);
    }
    progress_end(&p);
    return ok;
}

static bool report(const moved *r, duet_error *err)
{
    const duet_cluster_motion_result *last = &r->last;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", r->scene), NUMBER("objects", last->bodies),
             NUMBER("ranks", r->cluster->ranks.n), NUMBER("parts", r->args->parts),
             NUMBER("steps", last->step), NUMBER("ms_a_step", r->all_ms / (double)r->n_steps),
             NUMBER("contacts", last->contacts), NUMBER("colours", last->colours),
             NUMBER("ghosts", last->ghosts));
    json_add_hash(o, r->hash);
    return rendering_tell(o, r->args->json, "cli/report/ranks_motion.lua", err);
}

static bool tell(const moved *r, duet_error *err)
{
    if (duet_cluster_get_rank(r->cluster) > 0)
        return true;
    bool ok = report(r, err);
    fflush(stdout); // a launcher that was asked to stop, too, may end this rank
    return ok;
}

bool rank_motion_run(duet_cluster *cluster, const cluster_arguments *args, const char *scene,
                     duet_error *err)
{
    moved r = {.cluster = cluster, .args = args, .scene = scene};
    if (!begin(&r, err))
        return false;
    interrupt_react(INTERRUPT_NOTED);
    bool ok = rank_frames_begin(&r.frames, args->frames, cluster, err) && run_steps(&r, err) &&
              duet_cluster_get_state_hash(cluster, &r.hash, err) &&
              ranks_agree(&cluster->ranks, tell(&r, err), err) &&
              (!r.is_stopped || error_set(err, DUET_STATUS_INTERRUPTED, "stopped"));
    rank_frames_end(&r.frames);
    return ok;
}
