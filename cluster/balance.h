// SPDX-License-Identifier: MIT
// When the world is to be cut anew because its ranks take unequal times: once the slowest one has
// lost more than a cut takes.
#ifndef CLUSTER_BALANCE_H
#define CLUSTER_BALANCE_H

#include "cluster/partition.h"

// Steps of which the quickest counts, so that a slow one that was an accident does not.
enum { BALANCE_STEPS = 8 };

typedef struct balance {
    uint32_t steps;  // since the ranks were last compared
    double least_ms; // that this rank was busy in one of them
    double lost_ms;  // since the last cut: by the slowest rank, beyond the mean of all
    double cut_ms;   // that the last cut took; 0: not known
} balance;

// After a cut that took so long on this rank, or 0 where it says nothing of others: what was noted
// before counts no more.
void balance_begin(balance *b, double cut_ms);

// Notes a step without a cut, in which this rank was busy with its n homes for so long. True where
// a cut pays, whose weights p then has. Collective.
bool balance_note(balance *b, ranks *r, partition *p, double busy_ms, uint32_t n);

#endif
