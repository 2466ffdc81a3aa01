// SPDX-License-Identifier: MIT
#include "cli/cluster/rank.h"

#include "cli/cluster/rank_check.h"
#include "cli/cluster/rank_frames.h"
#include "cli/cluster/rank_picture.h"
#include "cli/cluster/rank_replay.h"
#include "cli/cluster/rank_tune.h"

#include "base/budget.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "cluster/moving.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

typedef struct moved {
    duet_cluster *cluster;
    const cluster_arguments *args;
    const char *scene;
    rank_frames frames;
    rank_picture pictures;
    rank_check check;
    rank_tune tune;
    rank_replay replay;
    duet_grade grade; // that the store gives what it knows of the ranks
    duet_cluster_motion_result last;
    double all_ms;
    double slowest_ms, mean_ms; // that ranks were busy, in all steps
    uint64_t n_steps;           // in this run, which may go on from a checkpoint
    uint64_t hash;
    bool is_stopped;
} moved;

// The first run of a command that is repeated after each crash finds no checkpoint of its own yet.
// Rank 0, which writes it, says for all whether it is there.
static const char *file_to_resume(const moved *r)
{
    const char *path = r->args->resume;
    uint64_t is_there = 0;
    if (!path || !r->args->checkpoint || strcmp(r->args->checkpoint, path) != 0)
        return path;
    is_there = duet_cluster_get_rank(r->cluster) == 0 && access(path, F_OK) == 0;
    ranks_sum(&r->cluster->ranks, &is_there, 1);
    return is_there > 0 ? path : NULL;
}

// Until a step is made, the last one is that of the file.
static bool take_begin(moved *r, const char *resume, duet_error *err)
{
    moving_counts counts = moving_get_counts(r->cluster->moving);
    r->last = (duet_cluster_motion_result){
        .step = counts.step, .bodies = counts.bodies, .ghosts = counts.ghosts};
    return counts.step <= r->args->steps ||
           bad_argument(err, "--steps %" PRIu64 ": %s was saved at step %" PRIu64, r->args->steps,
                        resume, counts.step);
}

// A given plan is kept, as in duet run, and so are the ghosts of a tuning. Bodies that nothing
// happens to have no profile.
static bool choose_ghosts(moved *r, duet_error *err)
{
    duet_profile profile;
    duet_error failure = {0};
    r->grade = DUET_GRADE_DEFAULT;
    if (r->args->tune_colours)
        return rank_tune_begin(&r->tune, r->cluster, r->args->steps - r->last.step, err);
    if (inputs_plan_given(&r->args->plan) ||
        duet_motion_get_effects(moving_get_motion(r->cluster->moving, 0)) == 0)
        return true;
    if (!duet_cluster_load_profile(r->cluster, NULL, &profile, &failure, err))
        return false;
    if (failure.status != DUET_STATUS_OK)
        say_failed(&failure);
    r->grade = profile.grade;
    return true;
}

// Pictures and a check are of the same scene, which rank 0 reads again.
static bool begin_beside(moved *r, const moving_start *start, duet_error *err)
{
    ranks *all = &r->cluster->ranks;
    moving *motion = r->cluster->moving;
    return rank_picture_begin(&r->pictures, all, motion, start, err) &&
           (!r->args->check ||
            rank_check_begin(&r->check, all, motion, start, r->args->replay, err));
}

static bool begin(moved *r, duet_error *err)
{
    scene_settings settings;
    const char *resume = file_to_resume(r);
    inputs_make_settings(&settings, &r->args->scene);
    const moving_start start = {.path = r->scene,
                                .settings = settings.list,
                                .n_settings = settings.n,
                                .resume = resume,
                                .pair = r->cluster->def.world.pair};
    return duet_cluster_begin_motion(r->cluster, r->scene, settings.list, settings.n, resume,
                                     err) &&
           take_begin(r, resume, err) && choose_ghosts(r, err) && begin_beside(r, &start, err) &&
           rank_replay_begin(&r->replay, r->cluster, r->args->replay, r->args->steps, err);
}

// After so many steps, and after the last one.
static bool save(const moved *r, bool is_last, duet_error *err)
{
    uint64_t every = r->args->every;
    bool due = is_last || (every > 0 && r->last.step % every == 0);
    return !r->args->checkpoint || !due ||
           duet_cluster_save_motion(r->cluster, r->args->checkpoint, err);
}

static void show_step(const moved *r, progress *p)
{
    const duet_cluster_motion_result *last = &r->last;
    if (r->cluster->ranks.n > 1 && last->mean_ms > 0)
        snprintf(p->note, sizeof p->note, "rank %" PRIu32 " slowest, %.2f of the mean",
                 last->slowest_rank, last->slowest_ms / last->mean_ms);
    progress_show(p, last->step);
}

static bool add_frames(moved *r, duet_error *err)
{
    return rank_frames_add(&r->frames, r->last.step, err) &&
           rank_picture_add(&r->pictures, r->last.step, err);
}

// A rank that is asked to stop stops all.
static bool run_steps(moved *r, duet_error *err)
{
    bool ok, tells = duet_cluster_get_rank(r->cluster) == 0;
    progress p = progress_begin("step", r->args->steps);
    ok = rank_check_compare(&r->check, err) && add_frames(r, err);
    while (ok && !r->is_stopped && r->last.step < r->args->steps) {
        ok = rank_replay_before(&r->replay, err) && rank_tune_before(&r->tune, err) &&
             duet_cluster_advance(r->cluster, &r->last, err);
        rank_tune_after(&r->tune, r->last.total_ms);
        if (ok && r->n_steps == 0)
            moving_begin_phases(r->cluster->moving);
        r->all_ms += r->last.total_ms;
        r->slowest_ms += r->last.slowest_ms;
        r->mean_ms += r->last.mean_ms;
        ++r->n_steps;
        uint64_t stops = ok && !budget_check_stop(NULL);
        if (ok)
            ranks_sum(&r->cluster->ranks, &stops, 1);
        r->is_stopped = stops > 0;
        ok = ok && rank_replay_after(&r->replay, err) && rank_check_compare(&r->check, err) &&
             rank_replay_compare(&r->replay, err) && add_frames(r, err) &&
             save(r, r->is_stopped || r->last.step == r->args->steps, err);
        if (tells)
            show_step(r, &p);
    }
    progress_end(&p);
    return ok;
}

// Who says how often ghosts come: this run's tuning or its own trial, which may be under way, the
// command line, the store by a grade, or nobody.
static const char *ghosts_by(const moved *r)
{
    const every_trial *trial = moving_get_trial(r->cluster->moving);
    return r->tune.state != TUNE_NONE          ? "tuned"
           : trial->turn > 0                   ? "trying"
           : trial->is_tried                   ? "tried"
           : inputs_plan_given(&r->args->plan) ? "given"
                                               : duet_grade_name(r->grade);
}

// The times of a step with each number of colours that was tried.
static void add_tried(cJSON *o, const moved *r)
{
    const every_trial *t = moving_get_trial(r->cluster->moving);
    cJSON *rows = t->is_tried ? cJSON_AddArrayToObject(o, "tried") : NULL;
    for (int i = 0; rows && i < EVERY_RIVALS; ++i)
        json_add(json_add_row(rows), NUMBER("colours_between", every_rivals[i]),
                 NUMBER("ms", 1e-6 * t->best_ns[i]));
}

// Tells where the time of rank 0's steps went; kernels are built in the first, which is left out.
static void add_phases(cJSON *o, const moved *r)
{
    const moving_phases *phases = moving_get_phases(r->cluster->moving);
    const double n = r->n_steps > 1 ? (double)(r->n_steps - 1) : 1.0;
    json_add(o, NUMBER("moves", (double)phases->n_moves));
    cJSON *rows = cJSON_AddArrayToObject(o, "phases");
    for (int i = 0; i < MOVING_PHASES; ++i) {
        const phase_cost *c = &phases->costs[i];
        json_add(json_add_row(rows), STRING("phase", moving_phase_name(i)), NUMBER("ms", c->ms / n),
                 NUMBER("wait_ms", c->wait_ms / n), NUMBER("exchanges", (double)c->exchanges / n),
                 NUMBER("bytes", (double)c->bytes / n), NUMBER("waits", (double)c->waits / n),
                 NUMBER("launches", (double)c->launches / n));
    }
}

static bool report(const moved *r, duet_error *err)
{
    const duet_cluster_motion_result *last = &r->last;
    double mean_ms = r->n_steps > 0 ? r->all_ms / (double)r->n_steps : 0;
    const uint32_t found = rank_tune_found(&r->tune);
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", r->scene), NUMBER("objects", last->bodies),
             NUMBER("ranks", r->cluster->ranks.n), NUMBER("parts", r->args->parts),
             NUMBER("step", last->step), NUMBER("steps", r->n_steps), NUMBER("ms_a_step", mean_ms),
             NUMBER("contacts", last->contacts), NUMBER("colours", last->colours),
             NUMBER("ghosts", last->ghosts),
             NUMBER("colours_between", found > 0 ? found : moving_get_every(r->cluster->moving)),
             STRING("colours_by", ghosts_by(r)));
    if (r->mean_ms > 0)
        json_add(o, NUMBER("slowest_part", r->slowest_ms / r->mean_ms),
                 NUMBER("slowest_rank", last->slowest_rank));
    add_tried(o, r);
    if (r->args->phases || r->args->json)
        add_phases(o, r);
    json_add_hash(o, r->hash);
    if (r->args->check)
        json_add(o, FLAG("equal", true)); // else it has failed
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
    const char *pieces = args->frames && strcmp(args->format, "vtu") == 0 ? args->frames : NULL;
    r.pictures.file = args->picture;
    r.pictures.folder = pieces ? NULL : args->frames;
    bool ok = begin(&r, err);
    interrupt_react(INTERRUPT_AWAITED);
    ok = ok && rank_frames_begin(&r.frames, pieces, cluster, err) && run_steps(&r, err) &&
         duet_cluster_get_state_hash(cluster, &r.hash, err) &&
         rank_picture_draw(&r.pictures, r.last.step, err) &&
         ranks_agree(&cluster->ranks, tell(&r, err), err) && rank_tune_end(&r.tune, err) &&
         (!r.is_stopped || error_set(err, DUET_STATUS_INTERRUPTED, "stopped"));
    rank_frames_end(&r.frames);
    rank_picture_end(&r.pictures);
    rank_check_end(&r.check);
    rank_replay_end(&r.replay);
    return ok;
}
