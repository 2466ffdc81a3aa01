// SPDX-License-Identifier: MIT
// What each rank of `duet cluster` does, once MPI has begun. All ranks do the same; rank 0 reads
// the scene and tells what there is to tell.
#ifndef CLI_CLUSTER_RANK_H
#define CLI_CLUSTER_RANK_H

#include "cli/cluster/stored_run.h"
#include "cli/commands/cluster.h"
#include "cluster/cluster.h"

// s NULL: the ranks are real. like: the run whose times simulated ranks take; NULL: none's.
bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              const stored_run *like, duet_error *err);

#endif
