// SPDX-License-Identifier: MIT
// What a rank sees, homes and ghosts in one array, and which of the pairs found there are its.
#ifndef CLUSTER_FOUND_H
#define CLUSTER_FOUND_H

#include "cluster/duet_cluster.h"
#include "cluster/homes.h"
#include "cluster/worker.h"

// A ghost among what is seen.
typedef struct seen_ghost {
    uint32_t place;
    uint32_t key; // the owner's
} seen_ghost;

// By ascending id, so that the order of two objects, which may decide a float's last bit, is
// that of one world with all objects.
typedef struct seen {
    object_rows rows;   // whose objects are the worker's memory
    uint8_t *is_ghost;  // a bit each
    seen_ghost *ghosts; // ascending
    uint64_t n_ghosts;
    uint64_t capacity, ghost_capacity; // for which there is memory
    const homes *homes;
    int self, n_ranks;
} seen;

// Writes the homes and n ghosts, those of each rank after those of the rank before, into the
// worker's memory. Not collective.
bool seen_fill(seen *s, const homes *h, const ranks *r, const parcels *ghosts, worker *w,
               duet_error *err);
void seen_end(seen *s);

// This rank's own pairs.
typedef struct own_pairs {
    duet_pair64 *pairs;
    uint64_t n;
    uint64_t hash;
    uint64_t capacity; // of pairs, for which there is memory
} own_pairs;

bool own_pairs_take(own_pairs *own, const seen *s, const worker_found *found, duet_error *err);
void own_pairs_end(own_pairs *own);

// The pair hash of one pair: below 2^32 that of duet_pairs_hash.
uint64_t pair64_hash(duet_pair64 pair);

#endif
