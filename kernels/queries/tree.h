// SPDX-License-Identifier: MIT
// How a box tree lies in memory, for kernels and host alike.
//
// The boxes are sorted along a curve, and each eight of them have a node with their
// bounds. Each eight nodes have one above them, up to a single root. So child k of node
// i is node 8 i + k of the level below, and no node says where its children are.
#ifndef KERNELS_QUERIES_TREE_H
#define KERNELS_QUERIES_TREE_H

#define TREE_WIDTH 8  // children of a node
#define TREE_LEVELS 10 // at most: 2^30 boxes
// A node: its children's lower corners, eight x, eight y, eight z, then the upper ones.
#define NODE_WORDS (6 * TREE_WIDTH)
// A box: its centre, half extents, the directions of its three edges, its id; as bounds
// lower and upper corner, -, its id.
#define TREE_BOX_WORDS_OF(is_bounds) ((is_bounds) ? 8 : 16)
#define TREE_BOX_AXES 6

// Counters; a 64-bit count is two words.
#define COUNT_HITS 0
#define COUNT_OPEN 2 // boxes that float leaves open
#define BAD_LATEST 4 // ~least number of a bad object or item; 0: none
#define COUNT_BAD 5  // bad objects
#define QUERY_COUNTERS 8

// Greatest x, y, z of points, greatest -x, -y, -z, and greatest half extent; each as a word that
// is in the order of the numbers, 0: none.
#define EXTENT_WORDS 7

#define NO_OBJECT 0xffffffffu // nothing was hit

#endif
