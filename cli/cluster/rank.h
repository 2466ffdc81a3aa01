// SPDX-License-Identifier: MIT
// What each rank of `duet cluster` does, once MPI has begun. All ranks do the same; rank 0 reads
// the scene and tells what there is to tell.
#ifndef CLI_CLUSTER_RANK_H
#define CLI_CLUSTER_RANK_H

#include "cli/commands/cluster.h"
#include "cluster/cluster.h"

// s NULL: the ranks are real.
bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              duet_error *err);

#endif
