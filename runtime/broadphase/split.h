// SPDX-License-Identifier: MIT
// Where the grid is cut in two slabs, by the work that lies on each side.
//
// A cut lies between two rows of cells, so that each slab is one run of keys.
// Pairs are found from the object that comes first, whose neighbours are at
// most one layer, one row and one cell ahead: so many ghost rows are added to
// the slab before the cut, and none to the one after it.
#ifndef RUNTIME_SPLIT_H
#define RUNTIME_SPLIT_H

#include "runtime/broadphase/part.h"

typedef struct split {
    uint32_t *rows; // [n_rows] objects in each
    uint32_t n_rows;
} split;

// Counts the objects of a dense grid of one level.
bool split_count(split *s, const part_task *task, duet_error *err);
void split_free(split *s);

// The slabs of A and B: A's home has about share of the work. A slab without
// rows is empty: its first and last are 0.
void split_cut(const split *s, const part_task *task, uint32_t share, part_range ranges[2]);

#endif
