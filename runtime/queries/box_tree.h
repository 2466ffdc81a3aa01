// SPDX-License-Identifier: MIT
// A tree over boxes on one device (kernels/queries/tree.h): what queries walk down.
#ifndef RUNTIME_BOX_TREE_H
#define RUNTIME_BOX_TREE_H

#include "kernels/queries/tree.h"
#include "runtime/opencl/radix_sort.h"

typedef struct box_tree {
    const device *device;
    kernel *key, *leaves, *level, *item_key;
    scan scan;
    radix_sort radix;

    uint32_t dims;
    duet_shape shape;

    buffer objects; // [n] poses or bounds
    buffer keys, ids, keys_spare, ids_spare;
    buffer items;  // whose order is sought
    buffer boxes;  // [slots][TREE_BOX_WORDS]
    buffer nodes;  // [..][NODE_WORDS]
    buffer levels; // [n_levels]
    buffer counters;
    cl_uint n, slots, n_levels; // of an empty tree 0
    cl_uint item_words;
    cl_float4 lower, per_cell;           // of the cells along the curve
    cl_uint below, n_below, at, n_slots; // of the level that is made
} box_tree;

enum { TREE_MOST_BOXES = 1 << 30 };

// Asks for the kernels, to be built with the set. All that is handed over outlives the tree.
bool box_tree_open(box_tree *t, const device *d, program_set *programs, uint32_t dims,
                   duet_shape shape, duet_error *err);
void box_tree_close(box_tree *t);

// Makes the tree of n objects, at most TREE_MOST_BOXES, which outlive it. BAD_OBJECT names
// the first one that is none, or has a number above 2^100; the tree is then to be made
// again.
bool box_tree_build(box_tree *t, timeline *times, const void *objects, uint32_t n, duet_error *err);

// No longer reads what it was made of, which may move then.
void box_tree_forget_objects(box_tree *t);

// Sorts n rows of so many words by the point that each begins with; their numbers are in
// ids then.
bool box_tree_order(box_tree *t, timeline *times, const buffer *items, uint32_t item_words,
                    uint32_t n, duet_error *err);

#endif
