// SPDX-License-Identifier: MIT
// The first step of a step: brings each object to the rank and the domain whose box holds it, and
// partitions the world if that is due.
#ifndef CLUSTER_MIGRATE_H
#define CLUSTER_MIGRATE_H

#include "cluster/classify.h"

typedef struct migration {
    owned *owned;
    partition *partition;
    worker *const *workers; // [2]
    double imbalance;       // the world is partitioned anew if a rank has so many times its due
    double unevenness;      // the most objects for those that are due, as the partition left it;
                            // 0: a new one is due
    uint64_t n_partitions;  // that were made
    classes classes;
} migration;

// Checks the objects, moves them, and leaves their boundary. Collective. After it succeeded on all
// ranks this one may have failed alone (is_well).
bool migrate(migration *m, ranks *r, duet_error *err);

#endif
