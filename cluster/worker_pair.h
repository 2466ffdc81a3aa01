// SPDX-License-Identifier: MIT
// The worker of a device pair: a world, whose memory the objects lie in.
#ifndef CLUSTER_WORKER_PAIR_H
#define CLUSTER_WORKER_PAIR_H

#include "cluster/worker.h"

typedef struct worker_pair {
    worker base;
    duet_world *world;
    struct world_fit *fits; // [n_fits] of each domain but this one
    uint32_t n_fits, domain;
    duet_object_kind kind;
    uint32_t bytes; // the size of an object
    char name[132];
} worker_pair;

#endif
