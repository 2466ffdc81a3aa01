// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_picture.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/draw/snapshot.h"
#include "cli/frames.h"

#include <inttypes.h>
#include <stdlib.h>

static bool draws(const rank_picture *p)
{
    return p->file || p->folder;
}

// Colours say where a body was at the scene's start, also where the job goes on from a file.
static bool read_start(rank_picture *p, const moving_start *start, duet_error *err)
{
    if (p->file && !snapshot_try(p->file, err))
        return false;
    p->look = calloc(1, sizeof *p->look);
    if (!p->look)
        return no_memory(err, "a picture");
    p->scene = duet_scene_load(start->path, start->settings, start->n_settings, err);
    if (!p->scene)
        return false;
    p->def = duet_scene_motion_def(p->scene, start->pair);
    duet_motion *motion = duet_motion_create_from_scene(&p->def, p->scene, NULL, err);
    bool ok = motion && snapshot_begin(p->look, &p->def, p->scene, motion, err);
    duet_motion_destroy(motion);
    return ok && (!p->folder || frame_folder_make(p->folder, err));
}

bool rank_picture_begin(rank_picture *p, ranks *r, moving *motion, const moving_start *start,
                        duet_error *err)
{
    p->ranks = r;
    p->motion = motion;
    return !draws(p) || ranks_agree(r, r->self > 0 || read_start(p, start, err), err);
}

typedef bool draw_call(const snapshot *s, const char *path, duet_motion *motion, double time,
                       duet_error *err);

static bool draw(const rank_picture *p, draw_call *call, const char *path, uint64_t step,
                 duet_error *err)
{
    duet_motion *whole;
    duet_error own = {0};
    bool ok = moving_gather(p->motion, &whole, &own);
    if (ok && is_well(&own) && whole)
        call(p->look, path, whole, (double)step * p->def.dt, &own);
    duet_motion_destroy(whole);
    ok = ok && ranks_agree(p->ranks, is_well(&own), &own);
    return ok || error_copy(err, &own);
}

bool rank_picture_draw(rank_picture *p, uint64_t step, duet_error *err)
{
    return !p->file || draw(p, snapshot_picture, p->file, step, err);
}

bool rank_picture_add(rank_picture *p, uint64_t step, duet_error *err)
{
    const double time = (double)step * duet_motion_get_def(moving_get_motion(p->motion, 0))->dt;
    text path = {0};
    if (!p->folder || !frame_is_due(p->n_frames, time))
        return true;
    text_add(&path, "%s/%05" PRIu64 ".png", p->folder, p->n_frames++);
    bool ok = ranks_agree(p->ranks, text_ok(&path, err), err) &&
              draw(p, snapshot_frame, text_chars(&path), step, err);
    text_free(&path);
    return ok;
}

void rank_picture_end(rank_picture *p)
{
    if (p->look)
        snapshot_end(p->look);
    free(p->look);
    duet_scene_destroy(p->scene);
}
