// SPDX-License-Identifier: MIT
// The work of each rank of `duet cluster` once MPI has begun. All ranks do the same; rank 0 also
// reads the scene and prints the results.
#ifndef CLI_CLUSTER_RANK_H
#define CLI_CLUSTER_RANK_H

#include "cli/commands/cluster.h"
#include "cluster/cluster.h"
#include "profiles/duet_profiles.h"

// s: NULL if the ranks are real. profile: the one whose times simulated ranks take, or NULL.
bool rank_run(const cluster_arguments *args, const char *scene, const simulation *s,
              const duet_stored_profile *profile, duet_error *err);

// With --steps, of a cluster that is open: advances the scene and prints, on rank 0, what has come
// of it.
bool rank_motion_run(duet_cluster *cluster, const cluster_arguments *args, const char *scene,
                     duet_error *err);

#endif
