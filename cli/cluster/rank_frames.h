// SPDX-License-Identifier: MIT
// Frames of a motion over ranks for ParaView: in each frame a file of every domain's own bodies,
// and one that names these; bodies.pvd, and ground.vtp if there is a ground.
#ifndef CLI_CLUSTER_RANK_FRAMES_H
#define CLI_CLUSTER_RANK_FRAMES_H

#include "cli/vtk/solid.h"
#include "cli/vtk/vtk_series.h"
#include "cluster/cluster.h"

typedef struct rank_frames {
    duet_cluster *cluster;
    vtk_series bodies; // folder NULL: no frames
    solid solids[SOLID_KINDS];
} rank_frames;

// The cluster has a motion, and is borrowed. Rank 0 makes the folder. Call rank_frames_end whatever
// this returns.
bool rank_frames_begin(rank_frames *f, const char *folder, duet_cluster *cluster, duet_error *err);
// Adds a frame if its time has come. Collective.
bool rank_frames_add(rank_frames *f, uint64_t step, duet_error *err);
void rank_frames_end(rank_frames *f);

#endif
