// SPDX-License-Identifier: MIT
// What each rank of `duet cluster` does once MPI has begun. All ranks do the same; rank 0 also
// reads the scene and prints the results.
#ifndef CLI_CLUSTER_RANK_H
#define CLI_CLUSTER_RANK_H

#include "cli/cluster/stored_run.h"
#include "cli/commands/cluster.h"
#include "cluster/cluster.h"

// A stored run or profile: simulated ranks take as long as its steps.
typedef struct stored_steps {
    const char *of; // "run" or "profile"
    uint32_t dims;
    char level[16];
    const stored_run *run; // NULL: it is a profile
} stored_steps;

// s: NULL if the ranks are real. like: NULL if they take their own times.
bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              const stored_steps *like, duet_error *err);

#endif
