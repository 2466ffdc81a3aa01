// SPDX-License-Identifier: MIT
// How often ghosts come, found while a motion over ranks takes its steps: each choice takes its
// turn for some of them, and since none changes a bit no step is lost. The winner is kept as a
// profile of these ranks.
#ifndef CLI_CLUSTER_RANK_TUNE_H
#define CLI_CLUSTER_RANK_TUNE_H

#include "cluster/cluster.h"
#include "runtime/selection/profile_subject.h"
#include "tuner/race.h"

typedef enum tune_state {
    TUNE_NONE,   // was not asked for
    TUNE_RACING, // a choice takes its turn
    TUNE_ENDED,  // and the winner takes the steps that are left
} tune_state;

typedef struct rank_tune {
    duet_cluster *cluster;
    tune_state state;
    profile_subject subject; // rank 0's, of the bodies that it began with
    char objective[CLUSTER_OBJECTIVE];
    race race;
    uint32_t turn;          // the choice under way
    uint32_t steps, n_left; // of a turn, and of this one
    double ms;              // of this turn
} rank_tune;

// The cluster has a motion, which takes so many steps more; that are at least so many that each
// choice gets its rounds. A store of rank 0 that cannot be written is refused. Collective.
bool rank_tune_begin(rank_tune *t, duet_cluster *cluster, uint64_t steps, duet_error *err);

// Before a step, and after one that took so long on all ranks. Collective.
bool rank_tune_before(rank_tune *t, duet_error *err);
void rank_tune_after(rank_tune *t, double ms);

// Returns how many colours the winner so far has between two exchanges; 0: there is none yet.
uint32_t rank_tune_found(const rank_tune *t);

// Keeps the winner, if the rounds suffice for one. Collective.
bool rank_tune_end(const rank_tune *t, duet_error *err);

#endif
