// SPDX-License-Identifier: MIT
// What a rank sees, homes and ghosts in one array, and which of the pairs found there are its.
#ifndef CLUSTER_FOUND_H
#define CLUSTER_FOUND_H

#include "cluster/duet_cluster.h"
#include "cluster/homes.h"
#include "cluster/worker.h"
#include "runtime/broadphase/pair_hash.h"

// An object that is at home elsewhere, and the key of that home.
typedef struct ghost_row {
    uint64_t id;
    const void *object;
    uint32_t key;
} ghost_row;

void ghosts_sort(ghost_row *ghosts, uint64_t n); // by ascending id

// Those of the messages that each rank sent, sorted, to be freed; NULL with NO_MEMORY. A rank's
// homes are in n_parts parts.
ghost_row *ghosts_read(const homes *h, const ranks *r, uint32_t n_parts, const parcels *messages,
                       duet_error *err);

// The key of an object at that home, which is a rank, or a part of this one.
uint32_t ghost_key(const homes *h, const void *object, uint32_t home, uint32_t n_homes);

// Some of this rank's homes and the ghosts that they may touch.
typedef struct sight {
    const uint32_t *rows; // ascending; NULL: all
    uint32_t n;
    const ghost_row *ghosts; // by ascending id
    uint64_t n_ghosts;
    uint32_t home, n_homes; // as ghost_key has them
} sight;

// The same where homes lie in place: the rows from `first` on, and ghosts in the places behind
// them, of which ids and keys are apart.
typedef struct sight_in_place {
    uint32_t first, n;
    const uint64_t *ghost_ids; // [n_ghosts]
    const uint32_t *ghost_keys;
    uint32_t n_ghosts;
    uint32_t home, n_homes;
} sight_in_place;

// Copies of homes and of ghosts, n_ghosts of them the last rows.
typedef struct sight_at_edges {
    object_rows rows;
    uint32_t n_ghosts;
    const uint32_t *ghost_keys;
    const uint16_t *ranges; // that homes lie in; NO_RANGE: in none
    uint32_t home, n_homes;
} sight_at_edges;

enum { NO_RANGE = UINT16_MAX };

// A ghost among what is seen.
typedef struct seen_ghost {
    uint32_t place;
    uint32_t key;
} seen_ghost;

// By ascending id, so that the order of two objects, which may decide a float's last bit, is
// that of one world with all objects. Where it decides nothing, homes that lie in the worker's
// memory are seen there, and ghosts behind them.
typedef struct seen {
    object_rows rows;           // whose objects are the worker's memory
    uint64_t *own_ids;          // NULL: rows' are the homes'
    uint32_t behind;            // from this place on all are ghosts,
    uint32_t *first_behind;     // [n_homes + 1] rank by rank, or
    const uint64_t *ids_behind; // each with its id and key, which the rows need not have; else NULL
    const uint32_t *keys_behind;
    const uint16_t
        *ranges;        // of homes: pairs of one range are found elsewhere; NULL: there are none
    bool is_border;     // pairs of two homes are found elsewhere
    uint8_t *is_ghost;  // a bit each, of those before; only where any is
    seen_ghost *ghosts; // [n_listed] these, ascending
    uint64_t n_listed;
    uint64_t n_ghosts;                 // all of them
    uint64_t capacity, ghost_capacity; // for which there is memory
    const homes *homes;
    uint32_t home, n_homes;
} seen;

// Whether the order of two objects decides nothing.
bool seen_in_any_order(duet_level level);

// Adds the ghosts in the messages behind homes that lie in the worker's memory. Not collective.
bool seen_append(seen *s, homes *h, const ranks *r, const parcels *ghosts, duet_error *err);

// Some homes where they lie, and ghosts that are written behind them before a worker sees these.
void seen_in_place(seen *s, const homes *h, const sight_in_place *from);

// Of homes that are seen in place without ghosts these, by ascending place, have left: no pair of
// theirs is this rank's. Not collective.
bool seen_leave_out(seen *s, const uint32_t *places, uint32_t n, duet_error *err);

// Copies of homes that ghosts may touch, of those that are gone, and behind them the ghosts in the
// messages. Not collective.
bool seen_at_border(seen *s, const homes *h, const ranks *r, const object_rows *rows,
                    const parcels *ghosts, duet_error *err);

// Homes at edges of ranges, and ghosts behind them.
void seen_at_edges(seen *s, const homes *h, const sight_at_edges *from);

// Writes the homes and ghosts into the worker's memory. Not collective.
bool seen_fill(seen *s, const homes *h, const sight *from, worker *w, duet_error *err);
void seen_end(seen *s);

// How many homes are there.
static inline uint64_t seen_homes(const seen *s)
{
    return s->rows.n - s->n_ghosts;
}

// The id of what is at a place.
static inline uint64_t seen_id(const seen *s, uint32_t place)
{
    return s->ids_behind && place >= s->behind ? s->ids_behind[place - s->behind]
                                               : s->rows.ids[place];
}

// This rank's own pairs.
typedef struct own_pairs {
    bool lists; // pairs has them; else they are counted
    duet_pair64 *pairs;
    uint64_t n;
    uint64_t hash;
    uint64_t capacity; // of pairs, for which there is memory
} own_pairs;

// None; keeps the memory.
void own_pairs_begin(own_pairs *own, bool lists);
// Adds those of what was found, all of which is in its spans where they are listed.
bool own_pairs_add(own_pairs *own, const seen *s, const worker_found *found, duet_error *err);
void own_pairs_end(own_pairs *own);

// The pair hash of one pair: below 2^32 that of duet_pairs_hash.
static inline uint64_t pair64_hash(duet_pair64 pair)
{
    uint64_t low = (pair.a << 32) | (pair.b & UINT32_MAX);
    uint64_t high = (pair.a >> 32 << 32) | (pair.b >> 32);
    return pair_hash(high ? low ^ pair_hash(high) : low); // that of 0 is 0
}

// BAD_OBJECT names the first of these that a device refuses.
bool seen_check_found(const seen *s, const worker_found *found, duet_error *err);

#endif
