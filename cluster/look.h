// SPDX-License-Identifier: MIT
// A look at all homes of a rank: which leave, and which others may touch. Most lie deep inside of
// the rank's part, and nothing more is asked of them.
#ifndef CLUSTER_LOOK_H
#define CLUSTER_LOOK_H

#include "cluster/homes.h"

// What one thread sees.
typedef struct glance {
    uint64_t bad;
    uint64_t first_bad; // its id
    double widest;
    level_boxes boxes; // of homes that are not deep inside, each of its level alone
    skim deep;         // the others
    row_list leavers;  // ascending, unless a device has skimmed them
    row_list border;
    row_list edges;   // where homes lie in ranges
    row_list outside; // of these those that do not lie in the box of theirs, by a device's look
    bool leapt;       // one of these lies farther from it than any object is wide
} glance;

// Copies of homes at edges, whose threads write them in any order.
typedef struct edge_rows {
    object_rows rows;
    uint16_t *ranges;   // that they lie in
    _Atomic uint64_t n; // more than there is space for: some are missing
} edge_rows;

typedef struct look {
    homes *h;
    const cut *c;
    reach inside;  // where homes lie so deep in this rank's part that they touch no others
    glance *parts; // [PARALLEL_MOST]
    glance all;    // whose lists only count
    const skim_block *blocks; // of the device that skimmed; NULL: the host did
    uint32_t base;            // the row of the first object of the blocks,
    uint32_t first;           // and of the blocks' the first object that is looked at
    uint32_t range;           // of a walk
    edge_rows *copies;        // that it makes
} look;

// By the host's threads, or with the device that the homes are on their way to, or by a walk. h, c
// and parts are given, and what parts held before is forgotten.
void look_at_all(look *l);
void look_at_rows(look *l); // by the host's threads

// A walk's look at one range, which a worker's device is sent and skims; homes at its edges,
// which are counted from twice as deep, are copied. False where the device does not skim.
bool look_at_range(look *l, uint32_t range, worker *w, edge_rows *copies);

#endif
