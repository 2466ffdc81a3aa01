// SPDX-License-Identifier: MIT
// Pictures of a motion over ranks, as `duet run` draws them. Rank 0 gathers all bodies for each,
// and needs memory for them.
#ifndef CLI_CLUSTER_RANK_PICTURE_H
#define CLI_CLUSTER_RANK_PICTURE_H

#include "cluster/moving.h"

typedef struct rank_picture {
    ranks *ranks;
    moving *motion;
    const char *file;   // for one picture; NULL: none
    const char *folder; // for frames; NULL: none
    uint64_t n_frames;
    duet_scene *scene; // rank 0's, if it draws
    duet_motion_def def;
    struct snapshot *look; // follows from the scene's start
} rank_picture;

// file and folder are set. The motion begins as `start` says. Collective. Call rank_picture_end
// whatever this returns.
bool rank_picture_begin(rank_picture *p, ranks *r, moving *motion, const moving_start *start,
                        duet_error *err);
// Draws the one picture, or a frame if its time has come. Collective.
bool rank_picture_draw(rank_picture *p, uint64_t step, duet_error *err);
bool rank_picture_add(rank_picture *p, uint64_t step, duet_error *err);
void rank_picture_end(rank_picture *p);

#endif
