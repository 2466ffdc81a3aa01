// SPDX-License-Identifier: MIT
// What a public tree is, for its queries.
#ifndef RUNTIME_TREE_H
#define RUNTIME_TREE_H

#include "runtime/narrowphase/ground_shape.h"
#include "runtime/opencl/thread_pool.h"
#include "runtime/queries/box_tree.h"
#include "runtime/queries/tree_share.h"

#include <stdatomic.h>

// One device's copy; device is NULL where it takes no part.
typedef struct tree_side {
    const device *device;
    gen *gen;
    program_set *programs; // kernels of the tree and of its queries
    box_tree boxes;
    buffer filters;         // [n] of the objects
    uint64_t filters_known; // the tree's filters_set when they were sent; 0: they were not
    timeline times;
    bool ok; // result of the last work of both sides
    duet_error err;
} tree_side;

enum { TREE_TUNED = 16 };

// The share that a profile brought for queries of one name.
typedef struct tuned_share {
    char query[QUERY_NAME];
    uint32_t share;
} tuned_share;

struct duet_tree {
    atomic_uint users; // the caller, and each query
    duet_tree_def def;
    tree_side sides[2];   // A, B
    thread_pool *driver;  // drives A while the caller's thread drives B
    void *objects;        // [n] as box_tree_shape says; stale until they are fetched
    duet_filter *filters; // [n] of them; NULL: all ones
    uint64_t filters_set; // from 1, how often they changed
    ground_shape ground;
    uint32_t n, n_hidden;
    int32_t middle[3]; // the cell that its cells and its items' count from
    bool fetched;
    tuned_share tuned[TREE_TUNED];
    uint32_t n_tuned;
};

void tree_hold(duet_tree *tree);

// The ground's id, behind those of the walls that a motion of the same objects has.
static inline uint32_t tree_ground_id(const duet_tree *tree)
{
    return tree->n + 6;
}

// Copies a ground that was checked, as ground_shape_copy; without one there is none from now on.
bool tree_take_ground(duet_tree *tree, const duet_heights *heights, const duet_mesh *mesh,
                      duet_error *err);

const char *tree_shape_name(const duet_tree *tree); // "rounded boxes"

// n objects of the tree's kind, as the tree has them; in origin cells settled, but from 0.
void tree_copy_rows(const duet_tree *tree, const void *objects, uint64_t n, void *rows);

// The objects' cells count from their middle from now on, which all are that the host has.
void tree_find_middle(duet_tree *tree);

// BAD_ARGUMENT where objects of that kind are not of the tree's shape.
bool tree_takes(const duet_tree *tree, duet_object_kind kind, duet_error *err);

// Space for n objects, which nothing knows yet.
bool tree_reserve_objects(duet_tree *tree, uint32_t n, duet_error *err);

// Space for a filter of each object; NULL with NO_MEMORY.
duet_filter *tree_reserve_filters(duet_tree *tree, duet_error *err);

// Makes both trees of the objects that are there: on the host, or in B's memory. The tree is empty
// after a failure.
bool tree_build(duet_tree *tree, uint32_t n_hidden, bool b_has_them, duet_error *err);

void tree_clear(duet_tree *tree);

// The host has the objects afterwards.
bool tree_fetch_objects(duet_tree *tree, duet_error *err);

// Does the work with a and b at the same time; NULL: that side has none. The first failure
// counts: A's, if it has one.
bool tree_run(duet_tree *tree, void (*work)(void *), void *a, void *b, duet_error *err);

#endif
