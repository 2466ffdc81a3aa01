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
    row_list edges; // where homes lie in ranges
} glance;

typedef struct look {
    homes *h;
    const cut *c;
    reach inside;  // where homes lie so deep in this rank's part that they touch no others
    glance *parts; // [PARALLEL_MOST]
    glance all;    // whose lists only count
    const skim_block *blocks; // of the device that skimmed; NULL: the host did
    uint32_t first;           // of the rows that are looked at
} look;

// By the host's threads, or with the device that the homes are on their way to. h, c and parts are
// given, and what parts held before is forgotten.
void look_at_all(look *l);

#endif
