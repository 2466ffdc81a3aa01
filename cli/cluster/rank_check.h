// SPDX-License-Identifier: MIT
// A motion over ranks beside one motion of the same scene, which rank 0 moves: whether the states
// of each step are the same, and what differs first.
#ifndef CLI_CLUSTER_RANK_CHECK_H
#define CLI_CLUSTER_RANK_CHECK_H

#include "cluster/moving.h"
#include "runtime/duet_replay.h"

typedef struct rank_check {
    ranks *ranks;
    moving *motion;      // NULL: nothing is compared
    duet_motion *one;    // rank 0's, as is
    duet_replay *replay; // what it is given, too; NULL: nothing
} rank_check;

// The motion has begun as `start` says, and both are given what was recorded in a file; NULL: in
// none. Collective. Call rank_check_end whatever this returns.
bool rank_check_begin(rank_check *c, ranks *r, moving *motion, const moving_start *start,
                      const char *replay, duet_error *err);

// Compares the states, after the step that both made unless the motion has just begun. Fails with
// WRONG_RESULT, and a line that says what differs first. Collective.
bool rank_check_compare(rank_check *c, duet_error *err);
void rank_check_end(rank_check *c);

#endif
