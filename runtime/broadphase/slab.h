// SPDX-License-Identifier: MIT
// The grid is cut by the work that lies on each side.
//
// A cut lies between two rows of cells, so that each slab is one run of keys. Pairs are found from
// the object that comes first, whose neighbours are at most one layer, one row and one cell ahead:
// that many ghost rows are added to the slab before the cut, and none to the one after it.
#ifndef RUNTIME_SLAB_H
#define RUNTIME_SLAB_H

#include "runtime/broadphase/grid.h"

// The objects that a part deals with. Its grid has the keys from key_from to key_to; of those it
// searches around the ones up to home_to, and of the sorted objects first .. last - 1. A whole grid
// has all keys; a slab the home keys and as many more as a neighbour can be ahead.
typedef struct part_range {
    uint32_t key_from, home_to, key_to;
    uint32_t other_from, other_to; // keys of the other part's slab
    uint32_t first, last;
    uint32_t homes;           // a slab's, when its objects were last counted
    uint32_t expected;        // about how many objects its grid gets
    uint32_t expected_ghosts; // a slab's, likewise: objects of no home key
} part_range;

// Invariant: the rows are counts of the objects that the grid was fitted to, or of later ones that
// still suited it. The ranges are the cut for `share` of n objects; n = 0: there is none.
typedef struct split {
    uint32_t *cell_rows; // [n_rows] objects in each row of cells
    uint32_t n_rows;     // 0: they are to be counted
    uint32_t share, n;
    part_range ranges[2]; // kept, because adding up the rows takes as long as 1/10 of a GPU's step
} split;

void split_free(split *s);

// Counts the objects again in the next cut, of another grid perhaps.
void split_forget(split *s);

// Whether a cut would count the objects, which the host must see for that.
bool split_is_stale(const split *s);

// The slabs of A and B, of a dense grid of one level: A's home has about share of the work.
// A slab without rows is empty: its first and last are 0.
bool split_cut(split *s, const grid *g, const grid_objects *objects, uint32_t share,
               part_range ranges[2], duet_error *err);

#endif
