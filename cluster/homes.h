// SPDX-License-Identifier: MIT
// The objects that a rank is responsible for, and how they change ranks.
#ifndef CLUSTER_HOMES_H
#define CLUSTER_HOMES_H

#include "cluster/cut.h"

typedef struct homes {
    object_form form;
    object_rows rows;
    reach *reaches;    // [rows.n], as are
    uint8_t *levels;   // by owner.h
    double widest;     // of all ranks' objects
    double unevenness; // what the last cut left: the most objects for those that are due
    bool is_cut;       // the objects are where the cut has them
} homes;

// Takes these objects, of which it owns the memory from here on, wherever they lie.
void homes_take(homes *h, object_rows *rows);
void homes_end(homes *h);

// Checks the objects, brings each to its rank, cuts the world where that was not done or where
// a rank has `imbalance` times what the last cut left it, and finds reaches and levels. Collective.
bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, duet_error *err);

#endif
