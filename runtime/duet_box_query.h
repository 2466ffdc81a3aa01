// SPDX-License-Identifier: MIT
// Box queries: which objects of a tree the caller's boxes collide with, a join of two sets.
#ifndef DUET_BOX_QUERY_H
#define DUET_BOX_QUERY_H

#include "duet_tree.h"

DUET_C_BEGIN

typedef struct duet_box_hit {
    uint32_t box; // index of the caller's box
    uint32_t id;  // id of the tree's object
} duet_box_hit;

typedef struct duet_box_query duet_box_query;

typedef struct duet_box_query_def {
    duet_tree *tree;           // held until the query is destroyed
    duet_level level;          // accuracy for poses; bounds are exact
    const duet_filter *filter; // filter of the caller's boxes; copied. NULL: finds every object
    int cookie;
} duet_box_query_def;

DUET_API duet_box_query_def duet_default_box_query_def(void); // certified

typedef struct duet_box_query_result {
    const duet_box_hit *hits; // [n_hits] by box and id; the query's, until its next call
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // time of each device's part
} duet_box_query_result;

// Creates a query and builds its kernels.
DUET_API duet_box_query *duet_box_query_create(const duet_box_query_def *def, duet_error *err);
DUET_API void duet_box_query_destroy(duet_box_query *query);

// Tests n boxes, fewer than 2^32, against all objects. kind must be the kind of the tree's
// objects. Two poses collide if a pair query at the def's level says so; the hits are the same
// on every device and at every share. BAD_OBJECT names the first box that is invalid or
// has a number above 2^100.
DUET_API bool duet_box_query_run(duet_box_query *query, duet_object_kind kind, const void *boxes,
                                 uint64_t n, duet_box_query_result *result, duet_error *err);

// Tests the tree's objects against each other: a hit is a pair, with the lower id in `box`.
// filters [n], one an object, say which objects can touch; NULL: all. The tree's filters and the
// def's filter are not read. The first call builds the kernels.
DUET_API bool duet_box_query_run_itself(duet_box_query *query, const duet_filter *filters,
                                        uint64_t n, duet_box_query_result *result, duet_error *err);

DUET_C_END

#endif
