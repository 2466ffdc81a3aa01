// SPDX-License-Identifier: MIT
// What a rank's devices see at one time: all of its homes and ghosts, or one part of several, so
// that devices need memory for a part alone.
//
// Parts are to a rank what ranks are to the world: boxes of the rank's space, each with ghosts of
// the other parts and of other ranks. So each pair is found in one part.
//
// Where the order of objects decides nothing, homes lie part after part, and devices read them
// there. A part's ghosts lie in a block, and change places with the rows behind the part for as
// long as it is searched. Else homes lie by ascending id, and parts are copies of some.
#ifndef CLUSTER_PARTS_H
#define CLUSTER_PARTS_H

#include "cluster/arrange.h"
#include "cluster/found.h"

#include <stdalign.h>

typedef struct home_part {
    reach inside;      // where its homes lie
    level_boxes boxes; // around those that may touch others, of each level and all finer ones
    uint32_t *rows;    // of the homes, ascending
    uint32_t n;
    ghost_row *ghosts; // by ascending id
    uint64_t n_ghosts;
    uint64_t first_ghost; // in the block
    bool is_open;         // its ghosts lie behind it
} home_part;

// What one thread of a loop counts for a part, and then where it writes; on cache lines of its own.
typedef struct portion {
    alignas(64) uint64_t homes;
    uint64_t ghosts;
    level_boxes boxes; // each of its level alone
} portion;

// Ghosts of all parts, part after part.
typedef struct ghost_block {
    object_rows rows;
    uint32_t *keys;
} ghost_block;

typedef struct parts {
    const homes *homes;
    uint32_t rank, n_ranks;
    uint32_t n;
    home_part *list;   // [n] where n > 1
    bisection cut;     // of the homes
    double unevenness; // that it left: the most homes of a part for their mean; 0: it is not made
    bool is_cut_anew;  // by the last division
    uint32_t *rows;    // [capacity]
    uint16_t *marks;   // [capacity] of homes, or of those at edges
    uint64_t capacity, row_capacity;
    uint32_t *border; // [all_border] rows of homes that may touch others, ascending
    uint64_t all_border, border_capacity;
    uint64_t n_border[PARALLEL_MOST]; // as a portion's
    portion *portions;                // [PARALLEL_MOST][n]
    parcels messages;                 // ghosts of other ranks
    ghost_row *ghosts;                // part after part
    home_range *ranges;               // [n] of homes in place
    stray *strays;                    // [n_strays] of these
    uint64_t n_strays;
    ghost_block block;
} parts;

bool parts_begin(parts *p, uint32_t n, const ranks *r, duet_error *err);
void parts_end(parts *p);

// Divides homes, which are where the cut has them and must stay there, and the ghosts in messages,
// which are the parts' from here on. Not collective.
bool parts_divide(parts *p, const homes *h, const cut *c, const ranks *r, parcels *messages,
                  duet_error *err);

sight parts_sight(const parts *p, uint32_t part);

// ---------------------------------------------------------------- in place, of several parts

// Homes that lie in a holder's memory are put in the order of parts; their edges are then unknown.
bool parts_cut_in_place(parts *p, homes *h, duet_error *err);

// Looks at the homes at edges: *even is false where parts must be cut first, for they never were,
// have become uneven, or very many homes have left theirs.
bool parts_look(parts *p, homes *h, bool *even, duet_error *err);

// After that: brings each home to its part, those that are gone behind all, and finds the ghosts.
// The messages are the parts' from here on.
bool parts_settle(parts *p, homes *h, parcels *messages, duet_error *err);

// The same after a walk, without ghosts. Homes that arrived or lie outside of their range's box
// are brought to their part; *even is false where parts_look and parts_settle are needed instead.
bool parts_look_after_walk(parts *p, homes *h, bool *even, duet_error *err);
bool parts_settle_after_walk(parts *p, homes *h, duet_error *err);

sight_in_place parts_sight_in_place(const parts *p, uint32_t part);
uint32_t parts_largest(const parts *p);

// The ghosts come to lie behind their part, and go back. What they take of others must not be
// needed meanwhile: parts_clash says whether two parts can be open at a time.
void parts_open(parts *p, homes *h, uint32_t part);
void parts_close(parts *p, homes *h, uint32_t part);
bool parts_clash(const parts *p, uint32_t a, uint32_t b);

// ---------------------------------------------------------------- of its own files

// A mark is a home's part, and whether it is of the kind that is asked for.
enum { PART_MARKED = 1 << 15 };

static inline uint32_t part_of_mark(uint16_t mark)
{
    return mark & (PART_MARKED - 1);
}

static inline portion *parts_portions(const parts *p, uint32_t thread)
{
    return p->portions + (size_t)thread * p->n;
}

// Makes a count what comes before it, and adds it to the sum.
static inline void count_before(uint64_t *count, uint64_t *sum)
{
    uint64_t n = *count;
    *count = *sum;
    *sum += n;
}

// Most homes of a part for their mean, and whether that is about what the cut left.
double parts_unevenness(const parts *p);
static inline bool parts_are_even(const parts *p)
{
    return parts_unevenness(p) <= 1.2 * p->unevenness;
}

// Planes for the homes as they are.
bool parts_cut(parts *p, duet_error *err);
bool parts_reserve_marks(parts *p, uint64_t n);
void parts_clear_portions(parts *p, uint32_t thread);
// Of the threads' portions.
void parts_join_boxes(parts *p, uint32_t n_threads);
// The ghosts of each part, from the homes that were marked, those that are gone and the messages.
bool parts_divide_ghosts(parts *p, duet_error *err);
void parts_forget_ghosts(parts *p);
void ghost_block_end(ghost_block *b);

#endif
