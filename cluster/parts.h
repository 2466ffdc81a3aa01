// SPDX-License-Identifier: MIT
// What a rank's devices see at one time: all of its homes and ghosts, or one part of several, so
// that devices need memory for a part alone.
//
// Parts are to a rank what ranks are to the world: boxes of the rank's space, each with ghosts of
// the other parts and of other ranks. So each pair is found in one part.
#ifndef CLUSTER_PARTS_H
#define CLUSTER_PARTS_H

#include "cluster/found.h"

#include <stdalign.h>

typedef struct home_part {
    reach inside;      // where its homes lie
    level_boxes boxes; // around those that may touch others, of each level and all finer ones
    uint32_t *rows;    // of the homes, ascending
    uint32_t n;
    ghost_row *ghosts; // by ascending id
    uint64_t n_ghosts;
} home_part;

// What one thread of a loop counts for a part, and then where it writes; on cache lines of its own.
typedef struct portion {
    alignas(64) uint64_t homes;
    uint64_t ghosts;
    level_boxes boxes; // each of its level alone
} portion;

typedef struct parts {
    const homes *homes;
    uint32_t rank, n_ranks;
    uint32_t n;
    home_part *list;   // [n] where n > 1
    bisection cut;     // of the homes
    double unevenness; // that it left: the most homes of a part for their mean; 0: it is not made
    bool is_cut_anew;  // by the last division
    uint32_t *rows;    // [capacity]
    uint16_t *marks;   // [capacity]
    uint32_t capacity; // of homes
    uint32_t *border;  // [all_border] rows of homes that may touch others, ascending
    uint64_t all_border, border_capacity;
    uint64_t n_border[PARALLEL_MOST]; // as a portion's
    portion *portions;                // [PARALLEL_MOST][n]
    parcels messages;                 // ghosts of other ranks
    ghost_row *ghosts;                // part after part
} parts;

bool parts_begin(parts *p, uint32_t n, const ranks *r, duet_error *err);
void parts_end(parts *p);

// Divides homes, which are where the cut has them and must stay there, and the ghosts in messages,
// which are the parts' from here on. Not collective.
bool parts_divide(parts *p, const homes *h, const cut *c, const ranks *r, parcels *messages,
                  duet_error *err);

sight parts_sight(const parts *p, uint32_t part);

#endif
