// SPDX-License-Identifier: MIT
// The objects that a rank is responsible for, and how they change ranks.
#ifndef CLUSTER_HOMES_H
#define CLUSTER_HOMES_H

#include "cluster/cut.h"
#include "cluster/owner.h"
#include "cluster/parallel.h"
#include "cluster/row_list.h"
#include "cluster/worker.h"

// Around the objects of each level and of all finer ones.
typedef struct level_boxes {
    reach upto[LEVELS];
} level_boxes;

// An object to those of its level alone; the level is by the widest of all.
void level_boxes_add(level_boxes *boxes, const reach *e, double widest);
// Those of each level alone become those with all finer ones.
void level_boxes_join(level_boxes *boxes);

struct look;

// Homes that lie side by side, up to row `end`, and those of a box alone but for some that have
// come there or left.
typedef struct home_range {
    reach box;
    uint32_t end;
} home_range;

// Homes lie by ascending id in memory of their own, or, in no order or in ranges, in that of the
// worker that searches them, where the application writes them and devices read them without a
// copy. There what arrives is added behind the others, and what leaves stays where it is, a ghost
// like any other, until homes_tidy. Ranges need not hold exactly what is in their boxes: what does
// not is at an edge.
typedef struct homes {
    object_form form;
    object_rows rows;
    object_rows spare; // memory for the rows of the next step
    worker *holder;    // whose memory rows.objects is; NULL: their own
    uint32_t *gone;    // [n_gone] ascending: rows whose objects have left for other ranks
    int *gone_to;      // these
    uint32_t n_gone;
    row_list renamed; // whose id is another since homes_forget_renamed, or who came or left
    bool all_renamed;
    uint64_t *arrived; // [n of ranks + 1] the rows that came from rank q: those from arrived[q] on
    row_list border;   // of homes that may touch another rank's
    level_boxes boxes; // around those
    const home_range
        *ranges; // [n_ranges] that homes lie in, side by side; 0: they lie in any order
    uint32_t n_ranges;
    row_list edges;    // of homes that do not lie deep in the box of their range, or in no range
    row_list outside;  // of these, after a walk, those that do not lie in it, or at its surface
    reach around;      // all homes, or a little more
    level_boxes *all;  // [n of ranks] of each, for the ghosts
    double widest;     // of all ranks' objects, or a little more
    double unevenness; // what the last cut left: the most objects for those that are due
    uint64_t n_cuts;   // that were made
    bool is_cut;       // the objects are where the cut has them
    bool ids_locked;   // by the holder
    parallel *threads;
    // Looks at homes in ranges in another way than by reading them all; NULL, or false: that is
    // done here. walked: the last look was that.
    bool (*walk)(void *context, struct look *l);
    void *walk_context;
    bool walked;
    bool leapt; // one of those outside lies farther from its range than any object is wide
    struct glance *glances; // [PARALLEL_MOST] of the last look, whose memory the next one uses
} homes;

// Takes these objects, of which it owns the memory from here on, wherever they lie.
void homes_take(homes *h, object_rows *rows);
void homes_end(homes *h);

// How many there are: the rows without those that are gone.
static inline uint32_t homes_count(const homes *h)
{
    return h->rows.n - h->n_gone;
}

// Closes the gaps that others left, with the last rows.
void homes_tidy(homes *h);

// Those that are gone become the last rows.
void homes_move_gone_last(homes *h);

// Ready to be written: returns how many they are, without gaps.
uint32_t homes_open(homes *h);

// Homes come to lie in a worker's memory, as they are, and give theirs back row by row; or they
// leave it again.
bool homes_move_in(homes *h, worker *w, duet_error *err);
bool homes_move_out(homes *h, duet_error *err);

// Memory for rows while they are put in order, all zero at first: ranges one after the other use
// the same, for to have it fresh from the system takes as long as to fill it.
typedef struct reordering {
    object_rows copy;
    uint32_t *order; // [copy.capacity]
} reordering;

void reordering_end(reordering *o);

// Rows [first, first + n) come to lie in the order that suits a worker which sees just these.
bool homes_put_in_order(homes *h, uint32_t first, uint32_t n, worker *w, reordering *o,
                        duet_error *err);

// Space for n rows behind the homes, in the holder's memory, where rows keep what they are.
bool homes_reserve_behind(homes *h, uint64_t n, duet_error *err);

// Finds the edges of ranges anew, of settled homes.
bool homes_find_edges(homes *h, const cut *c, duet_error *err);

// The holder's devices read ids where they lie.
void homes_lock_ids(homes *h);

// The holder knows the ids of all rows.
void homes_forget_renamed(homes *h);

// Whether a row came from that rank when homes were settled last: that rank has it already.
static inline bool homes_came_from(const homes *h, uint32_t row, int rank)
{
    return h->holder && row >= h->arrived[rank] && row < h->arrived[rank + 1];
}

// Writes the objects of messages to these rows from `at` on, by all threads.
void homes_write_messages(const homes *h, object_rows *rows, uint64_t at, const parcels *messages);

// Writes the objects of messages behind the rows, in the holder's memory.
bool homes_write_behind(homes *h, const parcels *messages, duet_error *err);

// Checks the objects, brings each to its rank, cuts the world where that was not done or where
// a rank has `imbalance` times what the last cut left it, and finds their boxes. Collective.
// *settled: whether this rank is well; false too where it fails alone at the end.
bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, bool *settled, duet_error *err);

#endif
