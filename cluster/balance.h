// SPDX-License-Identifier: MIT
// Says when a new partition of the world pays because the ranks take unequal times: once the
// slowest one has lost more than a partition takes.
#ifndef CLUSTER_BALANCE_H
#define CLUSTER_BALANCE_H

#include "cluster/partition.h"

// Steps of which the quickest counts, so that a slow one that was an accident does not.
enum { BALANCE_STEPS = 8 };

typedef struct balance {
    uint32_t steps;  // since the ranks were last compared
    double least_ms; // that this rank was busy in one of them
    double lost_ms;  // since the last partition: slowest rank minus mean
    double price_ms; // the last partition's price; 0: not known
} balance;

// Resets the statistics after a partition that took price_ms here; 0: not representative.
void balance_begin(balance *b, double price_ms);

// Notes a step without a partition, in which this rank was busy with its n objects for busy_ms.
// Returns whether a new partition pays, whose weights p then has. Collective.
bool balance_note(balance *b, ranks *r, partition *p, double busy_ms, uint32_t n);

#endif
