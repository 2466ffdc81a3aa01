// SPDX-License-Identifier: MIT
// `duet cluster SCENE --steps K` on each rank, of a cluster that is open.
#ifndef CLI_CLUSTER_RANK_MOTION_H
#define CLI_CLUSTER_RANK_MOTION_H

#include "cli/commands/cluster.h"
#include "cluster/cluster.h"

// Advances the scene and prints, on rank 0, what has come of it.
bool rank_motion_run(duet_cluster *cluster, const cluster_arguments *args, const char *scene,
                     duet_error *err);

#endif
