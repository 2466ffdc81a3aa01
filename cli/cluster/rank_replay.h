// SPDX-License-Identifier: MIT
// Recorded commands, which rank 0 reads and all ranks give to their motion, step by step.
#ifndef CLI_CLUSTER_RANK_REPLAY_H
#define CLI_CLUSTER_RANK_REPLAY_H

#include "cluster/cluster.h"
#include "runtime/commands/replay.h"

typedef struct rank_replay {
    duet_cluster *cluster;
    const char *path;    // NULL: nothing was recorded
    duet_replay *file;   // rank 0's
    uint64_t n, n_given; // commands
    uint64_t steps_left;
} rank_replay;

// Reads the file, which has so many steps at least, and looks whether the motion, which has begun,
// is as the recorded one was. Collective, as are the others. Call rank_replay_end whatever this
// returns.
bool rank_replay_begin(rank_replay *r, duet_cluster *cluster, const char *path, uint64_t steps,
                       duet_error *err);
void rank_replay_end(rank_replay *r);

// Gives the commands that come before the next step; notes a step, compares its hash if that was
// recorded, and after the last recorded one gives what follows.
bool rank_replay_before(rank_replay *r, duet_error *err);
bool rank_replay_after(rank_replay *r, duet_error *err);

// After the last recorded step compares the hash with the recorded one.
bool rank_replay_compare(rank_replay *r, duet_error *err);

#endif
