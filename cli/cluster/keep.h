// SPDX-License-Identifier: MIT
// What a run showed, and the network between its ranks, as rows of the user's profile store.
#ifndef CLI_CLUSTER_KEEP_H
#define CLI_CLUSTER_KEEP_H

#include "cluster/duet_cluster.h"
#include "cluster/ranks.h"
#include "profiles/cluster_run.h"

// Measures the network, for some tenths of a second, and has rank 0 write the store. run's fields
// of times are ns. Collective; rows are of all ranks.
bool keep_run(ranks *r, const profile_cluster_run *run, const duet_cluster_rank *rows,
              duet_error *err);

#endif
