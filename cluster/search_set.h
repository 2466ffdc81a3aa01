// SPDX-License-Identifier: MIT
// The objects that a worker searches at one time: some that this rank owns, and ghosts behind them.
//
//   whole     a domain with its ghosts: a single domain where it lies, or one of several as a copy
//   inner     a single domain where it lies, without ghosts
//   boundary  a copy of what may touch other domains' objects, and of the ghosts. Pairs within the
//             domain are found in the inner set, and are left out
#ifndef CLUSTER_SEARCH_SET_H
#define CLUSTER_SEARCH_SET_H

#include "cluster/ghosts.h"

typedef enum set_kind { SET_WHOLE, SET_INNER, SET_BOUNDARY } set_kind;

typedef struct search_set {
    set_kind kind;
    const owned *owned;
    object_rows rows;   // its objects are the worker's memory
    uint32_t n_own;     // the first n_own rows; the others are ghosts
    uint32_t *keys;     // [n of ghosts]
    uint32_t n_leavers; // among the own rows: all of owned's, or none
    uint8_t *is_leaver; // a bit for each of the own rows; only if there are leavers
    uint64_t *ids;      // [ids_capacity] of copies
    uint64_t keys_capacity, bits_capacity, ids_capacity;
    uint32_t place, n_places; // the own rows' place, among n_places
} search_set;

static inline uint32_t search_set_ghosts(const search_set *s)
{
    return s->rows.n - s->n_own;
}

// Makes the set a single domain with its ghosts, where they lie.
bool search_set_in_place(search_set *s, owned *o, const ghosts *g, const ranks *r, duet_error *err);
// Makes the set a single domain without ghosts.
bool search_set_inner(search_set *s, const owned *o, const ranks *r, duet_error *err);
// Copies a domain and its ghosts into a worker's memory.
bool search_set_copy_domain(search_set *s, const owned *o, const ghosts *g, const ranks *r,
                            uint32_t index, worker *w, duet_error *err);
bool search_set_copy_boundary(search_set *s, const owned *o, const ghosts *g, const ranks *r,
                              worker *w, duet_error *err);
void search_set_end(search_set *s);

// Searches it by a worker that has it. counts: pairs of two own objects need not come to the host
// if the worker can count them.
bool search_set_find(search_set *s, worker *w, bool counts, worker_found *found, duet_error *err);

// Whether a pair, by rows of the set, is one that this rank is to count.
bool search_set_owns_with_ghost(const search_set *s, duet_pair pair);

static inline bool search_set_owns(const search_set *s, duet_pair pair)
{
    if ((pair.a >= s->n_own) | (pair.b >= s->n_own))
        return search_set_owns_with_ghost(s, pair);
    if (s->n_leavers > 0 && ((s->is_leaver[pair.a / 8] >> pair.a % 8 & 1) ||
                             (s->is_leaver[pair.b / 8] >> pair.b % 8 & 1)))
        return false;
    return s->kind != SET_BOUNDARY;
}

#endif
