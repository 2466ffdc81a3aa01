// SPDX-License-Identifier: MIT
// A tree over boxes on one device (kernels/queries/tree.h): what queries walk down.
#ifndef RUNTIME_BOX_TREE_H
#define RUNTIME_BOX_TREE_H

#include "kernels/queries/tree.h"
#include "runtime/opencl/radix_sort.h"

typedef struct box_tree {
    const device *device;
    kernel *key, *leaves, *level, *ray_key;
    scan scan;
    radix_sort radix;

    buffer objects; // [n] poses, while the tree is made
    buffer keys, ids, keys_spare, ids_spare;
    buffer rays;   // whose order is sought
    buffer boxes;  // [slots][TREE_BOX_WORDS]
    buffer nodes;  // [..][NODE_WORDS]
    buffer levels; // [n_levels]
    buffer counters;
    cl_uint n, slots, n_levels;
    cl_float4 lower, per_cell;           // of the cells along the curve
    cl_uint below, n_below, at, n_slots; // of the level that is made
} box_tree;

// Asks for the kernels, to be built with the set. All that is handed over outlives the tree.
bool box_tree_open(box_tree *t, const device *d, program_set *programs, uint32_t dims,
                   duet_error *err);
void box_tree_close(box_tree *t);

// Makes the tree of n poses, at most 2^30. BAD_OBJECT names the first one that is not a
// box, or has a number above 2^100.
bool box_tree_build(box_tree *t, timeline *times, const duet_pose *poses, uint32_t n, uint32_t dims,
                    duet_error *err);

// Sorts n rays by where they begin; their numbers are in ids then.
bool box_tree_order_rays(box_tree *t, timeline *times, const buffer *rays, uint32_t n,
                         duet_error *err);

#endif
