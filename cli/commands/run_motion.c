// SPDX-License-Identifier: MIT
#include "cli/commands/run.h"

#include "base/error.h"
#include "cli/command_text.h"
#include "cli/draw/snapshot.h"
#include "cli/frames.h"
#include "cli/interrupt.h"
#include "cli/report/motion_report.h"
#include "cli/say.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

// A run of so few steps is timed by stages, though a GPU then takes longer.
enum { FEW_STEPS = 64, ROWS_TOLD = 10 };

typedef struct moved {
    const arguments *args;
    const duet_scene *scene;
    duet_motion_def def;
    duet_motion *motion;
    duet_replay *replay; // NULL: no recorded commands
    snapshot look;       // draws a picture and frames
    frames frames;
    progress shown;
    motion_report report;
} moved;

static double time_of(const moved *r)
{
    return (double)duet_motion_get_step(r->motion) * r->def.dt;
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
    uint64_t done = r->report.done, every = r->args->steps / ROWS_TOLD;
    bool due =
        done == 1 || r->report.last.step == r->args->steps || (every > 0 && done % every == 0);
    if (!due || r->args->json)
        return true;
    progress_hide(&r->shown);
    return motion_report_row(&r->report, err);
}

static bool save_checkpoint(moved *r, duet_error *err)
{
    return !r->args->checkpoint || r->report.last.step % r->args->every != 0 ||
           duet_motion_save(r->motion, r->args->checkpoint, err);
}

static bool step(moved *r, duet_error *err)
{
    duet_motion_result last;
    if (!(r->replay ? duet_replay_advance(r->replay, r->motion, &last, err)
                    : duet_motion_advance(r->motion, &last, err)))
        return false;
    motion_report_add(&r->report, &last);
    return save_checkpoint(r, err) && tell_step(r, err) && frames_add(&r->frames, time_of(r), err);
}

static bool open_motion(moved *r, duet_device_pair *pair, duet_error *err)
{
    r->def = duet_scene_motion_def(r->scene, pair);
    r->def.stage_times = r->args->steps <= FEW_STEPS;
    r->motion = inputs_make_motion(r->scene, &r->def, r->args->pair, &r->args->plan,
                                   &r->report.profile, err);
    r->report.scene = duet_scene_get_info(r->scene);
    r->report.motion = r->motion;
    r->report.plan_given = inputs_plan_given(&r->args->plan);
    bool draws = r->args->picture || r->args->frames;
    return r->motion && (!draws || snapshot_begin(&r->look, &r->def, r->scene, r->motion, err));
}

// The first run of a command that is repeated after each crash finds no checkpoint of its own yet.
static bool resume(moved *r, duet_error *err)
{
    const char *path = r->args->resume;
    duet_error why = {0};
    if (!path)
        return true;
    if (!duet_motion_load(r->motion, path, &why)) {
        bool first = why.status == DUET_STATUS_NOT_FOUND && r->args->checkpoint &&
                     strcmp(r->args->checkpoint, path) == 0;
        return first || error_copy(err, &why);
    }
    uint64_t step = duet_motion_get_step(r->motion);
    return step <= r->args->steps ||
           bad_argument(err, "--steps %" PRIu64 ": %s was saved at step %" PRIu64, r->args->steps,
                        path, step);
}

static bool open_replay(moved *r, duet_error *err)
{
    if (!r->args->replay)
        return true;
    r->replay = duet_replay_create(r->args->replay, err);
    return r->replay && inputs_check_recorded(r->replay, r->args->replay, r->args->steps, err);
}

static bool save_recording(moved *r, duet_error *err)
{
    return !r->args->record || duet_motion_save_recording(r->motion, r->args->record, err);
}

// The first step takes seconds where the driver compiles in it.
static void begin_progress(moved *r)
{
    r->shown = progress_begin("step", r->args->steps);
    if (!inputs_have_compiled())
        return;
    snprintf(r->shown.note, sizeof r->shown.note, "the first one compiles for the device");
    progress_show(&r->shown, duet_motion_get_step(r->motion));
    *r->shown.note = '\0';
}

static bool run_steps(moved *r, duet_error *err)
{
    bool ok = begin_frames(r, err) && (!r->args->picture || snapshot_try(r->args->picture, err));
    begin_progress(r);
    while (ok && duet_motion_get_step(r->motion) < r->args->steps && !interrupt_asked()) {
        ok = step(r, err);
        progress_show(&r->shown, duet_motion_get_step(r->motion));
    }
    progress_end(&r->shown);
    uint64_t hash = 0;
    ok = ok && duet_motion_get_hash(r->motion, &hash, err) && draw_picture(r, err) &&
         save_recording(r, err);
    ok = ok && motion_report_end(&r->report, hash, r->args->json, err);
    return ok && (r->args->json || interrupt_check(err));
}

// A run from the fall to the rest takes long to tune by; 60 steps are a second of most scenes.
static void write_tuning(text *tuning, const arguments *args, const char *path,
                         const duet_device_pair *pair)
{
    text_add(tuning, "duet tune");
    command_text_scene(tuning, path, &args->scene);
    command_text_pair(tuning, pair);
    command_text_option(tuning, "steps", "60");
}

bool run_motion(const arguments *args, const char *path, const duet_scene *scene,
                duet_device_pair *pair, duet_error *err)
{
    moved r = {.args = args, .scene = scene};
    write_tuning(&r.report.tuning, args, path, pair);
    bool ok = open_motion(&r, pair, err) && resume(&r, err) && open_replay(&r, err) &&
              (!args->record || duet_motion_record(r.motion, err));
    ok = ok && (args->json || motion_report_begin(&r.report, err)) && run_steps(&r, err);
    frames_end(&r.frames);
    snapshot_end(&r.look);
    duet_replay_destroy(r.replay);
    duet_motion_destroy(r.motion);
    text_free(&r.report.tuning);
    return ok;
}
