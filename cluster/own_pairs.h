// SPDX-License-Identifier: MIT
// The pairs that this rank is to count, by global ids.
#ifndef CLUSTER_OWN_PAIRS_H
#define CLUSTER_OWN_PAIRS_H

#include "cluster/duet_cluster.h"
#include "cluster/search_set.h"
#include "runtime/broadphase/pair_hash.h"

typedef struct own_pairs {
    bool lists; // pairs has them; else they are only counted
    duet_pair64 *pairs;
    uint64_t n;
    uint64_t hash;
    uint64_t capacity; // pairs for which there is memory
} own_pairs;

// Begins with none; keeps the memory.
void own_pairs_begin(own_pairs *own, bool lists);
// Adds what was found in a set. If pairs are listed, all of them must be in its spans.
bool own_pairs_add(own_pairs *own, const search_set *s, const worker_found *found, duet_error *err);
void own_pairs_end(own_pairs *own);

// Returns the pair hash of one pair: if both ids are below 2^32, the hash of duet_pairs_hash.
static inline uint64_t pair64_hash(duet_pair64 pair)
{
    uint64_t low = (pair.a << 32) | (pair.b & UINT32_MAX);
    uint64_t high = (pair.a >> 32 << 32) | (pair.b >> 32);
    return pair_hash(high ? low ^ pair_hash(high) : low); // pair_hash(0) is 0
}

#endif
