// SPDX-License-Identifier: MIT
// The objects that a rank is responsible for, and how they change ranks.
#ifndef CLUSTER_HOMES_H
#define CLUSTER_HOMES_H

#include "cluster/cut.h"
#include "cluster/owner.h"
#include "cluster/parallel.h"

// Around the objects of each level and of all finer ones.
typedef struct level_boxes {
    reach upto[LEVELS];
} level_boxes;

// Those of each level alone become those with all finer ones.
void level_boxes_join(level_boxes *boxes);

typedef struct homes {
    object_form form;
    object_rows rows;
    object_rows spare; // memory for the rows of the next step
    level_boxes boxes; // around the homes, or more
    level_boxes *all;  // [n of ranks] of each, for the ghosts
    double widest;     // of all ranks' objects, or a little more
    double unevenness; // what the last cut left: the most objects for those that are due
    uint64_t n_cuts;   // that were made
    bool is_cut;       // the objects are where the cut has them
    parallel *threads;
} homes;

// Takes these objects, of which it owns the memory from here on, wherever they lie.
void homes_take(homes *h, object_rows *rows);
void homes_end(homes *h);

// Checks the objects, brings each to its rank, cuts the world where that was not done or where
// a rank has `imbalance` times what the last cut left it, and finds their boxes. Collective.
bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, duet_error *err);

#endif
