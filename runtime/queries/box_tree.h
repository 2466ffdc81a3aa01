// SPDX-License-Identifier: MIT
// A tree over boxes on one device (kernels/queries/tree.h): what queries walk down.
#ifndef RUNTIME_BOX_TREE_H
#define RUNTIME_BOX_TREE_H

#include "kernels/queries/far_row.h"
#include "kernels/queries/rounded_row.h"
#include "kernels/queries/tree.h"
#include "runtime/opencl/radix_sort.h"

typedef struct box_tree {
    const device *device;
    kernel *measure, *key, *leaves, *level, *item_key;
    scan scan;
    radix_sort radix;

    uint32_t dims;
    duet_shape shape;
    float origin; // the edge of origin cells, or 0

    buffer objects; // [n] poses, bounds or rounded boxes
    buffer keys, ids, keys_spare, ids_spare;
    buffer items;  // items to be ordered
    buffer boxes;  // [slots][TREE_BOX_WORDS]
    buffer nodes;  // [..][NODE_WORDS]
    buffer levels; // [n_levels]
    buffer extent; // [EXTENT_WORDS]
    buffer counters;
    cl_uint n, slots, n_levels; // 0 in an empty tree
    cl_uint first_item, item_words, item_cell;
    cl_uint n_listed, step;              // boxes or items that are measured or get keys
    cl_uint below, n_below, at, n_slots; // the level being built
} box_tree;

enum { TREE_MOST_BOXES = 1 << 30 };

// Returns the shape that the tree stores: spheres are rounded boxes without a core.
duet_shape box_tree_shape(duet_shape shape);
size_t box_tree_width(duet_shape shape, float origin); // bytes of one

// Asks for the kernels, to be built with the set. All that is handed over outlives the tree.
bool box_tree_open(box_tree *t, const device *d, program_set *programs, uint32_t dims,
                   duet_shape shape, float origin, duet_error *err);
void box_tree_close(box_tree *t);

// Memory for n objects: what the host has, which outlives the tree, or as much of the device's.
bool box_tree_hold(box_tree *t, const device *d, void *objects, uint32_t n, duet_error *err);

// Makes the tree of the n objects that it holds, at most TREE_MOST_BOXES. BAD_OBJECT names the
// first one that is none, or has a number above 2^100, where there are more of these than
// hidden ones, which no query finds; the tree is then to be made again.
bool box_tree_build(box_tree *t, timeline *times, uint32_t n, uint32_t n_hidden, duet_error *err);

// No longer reads what it was made of, which may move then.
void box_tree_forget_objects(box_tree *t);

// Sorts n rows of so many words, from row `first` on, by the point that each begins with, in
// origin cells with the cell at that word; their numbers, which count from there, are in ids then.
bool box_tree_order(box_tree *t, timeline *times, const buffer *items, uint32_t item_words,
                    uint32_t item_cell, uint32_t first, uint32_t n, duet_error *err);

#endif
