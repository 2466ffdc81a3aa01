// SPDX-License-Identifier: MIT
// What each rank of `duet cluster` does, once MPI has begun. All ranks do the same; rank 0 reads
// the scene and tells what there is to tell.
#ifndef CLI_CLUSTER_RANK_H
#define CLI_CLUSTER_RANK_H

#include "cli/cluster/stored_run.h"
#include "cli/commands/cluster.h"
#include "cluster/cluster.h"

// The steps whose times simulated ranks take.
typedef struct stored_steps {
    const char *of; // "run" or "profile"
    uint32_t dims;
    char level[16];
    const stored_run *run; // NULL: they are a profile's
} stored_steps;

// s NULL: the ranks are real. like NULL: they take their own times.
bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              const stored_steps *like, duet_error *err);

#endif
