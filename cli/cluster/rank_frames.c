// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_frames.h"

#include "cli/frames.h"
#include "cli/vtk/vtk_bodies.h"
#include "cli/vtk/vtk_ground.h"
#include "cluster/moving.h"

#include <inttypes.h>

static const duet_motion_def *def_of(const rank_frames *f)
{
    return duet_motion_get_def(moving_get_motion(f->cluster->moving, 0));
}

static bool is_first(const rank_frames *f)
{
    return f->cluster->ranks.self == 0;
}

bool rank_frames_begin(rank_frames *f, const char *folder, duet_cluster *cluster, duet_error *err)
{
    *f = (rank_frames){.cluster = cluster,
                       .bodies = {.folder = folder, .name = "bodies", .ending = "pvtu"}};
    if (!folder)
        return true;
    solids_make(f->solids, def_of(f)->dims);
    bool ok = !is_first(f) || (frame_folder_make(folder, err) &&
                               vtk_ground_write_once(folder, def_of(f), 0.0, err));
    return ranks_agree(&cluster->ranks, ok, err);
}

// ---------------------------------------------------------------- a frame

// "bodies_00007", of which pieces and the file that names them have their names.
static bool name_frame(const rank_frames *f, text *stem, duet_error *err)
{
    text_add(stem, "%s_%05" PRIu64, f->bodies.name, f->bodies.n);
    return text_ok(stem, err);
}

static bool write_bodies(const rank_frames *f, uint32_t k, const char *path, double time,
                         duet_error *err)
{
    duet_motion *motion = moving_get_motion(f->cluster->moving, k);
    body_states bodies;
    bool ok =
        body_states_read(&bodies, motion, err) && body_states_read_asleep(&bodies, motion, err);
    if (ok) {
        moving_get_own_ids(f->cluster->moving, k, bodies.ids);
        ok = vtk_bodies_write(path, &bodies, f->solids, bodies.def.dims, time, err);
    }
    body_states_free(&bodies);
    return ok;
}

static bool write_piece(const rank_frames *f, uint32_t k, const char *stem, double time,
                        duet_error *err)
{
    const uint32_t parts = f->cluster->def.parts;
    text path = {0};
    text_add(&path, "%s/%s_%" PRIu32 ".vtu", f->bodies.folder, stem,
             (uint32_t)f->cluster->ranks.self * parts + k);
    bool ok = text_ok(&path, err) && write_bodies(f, k, text_chars(&path), time, err);
    text_free(&path);
    return ok;
}

static bool write_pieces(const rank_frames *f, const char *stem, double time, duet_error *err)
{
    bool ok = true;
    for (uint32_t k = 0; ok && k < f->cluster->def.parts; ++k)
        ok = write_piece(f, k, stem, time, err);
    return ok;
}

// Rank 0 names the pieces once all of them are there; the others count frames.
static bool name_pieces(rank_frames *f, const char *stem, double time, duet_error *err)
{
    const uint32_t n = (uint32_t)f->cluster->ranks.n * f->cluster->def.parts;
    if (!is_first(f)) {
        ++f->bodies.n;
        return true;
    }
    const char *path = vtk_series_next(&f->bodies, err);
    return path && vtk_bodies_write_parallel(path, stem, n, time, err) &&
           vtk_series_add(&f->bodies, time, err);
}

bool rank_frames_add(rank_frames *f, uint64_t step, duet_error *err)
{
    ranks *r = &f->cluster->ranks;
    text stem = {0};
    const double time = (double)step * def_of(f)->dt;
    if (!f->bodies.folder || !frame_is_due(f->bodies.n, time))
        return true;
    bool ok = name_frame(f, &stem, err) && write_pieces(f, text_chars(&stem), time, err);
    ok = ranks_agree(r, ok, err) &&
         ranks_agree(r, name_pieces(f, text_chars(&stem), time, err), err);
    text_free(&stem);
    return ok;
}

void rank_frames_end(rank_frames *f)
{
    vtk_series_free(&f->bodies);
}
