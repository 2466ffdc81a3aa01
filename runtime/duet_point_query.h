// SPDX-License-Identifier: MIT
// Point queries: which boxes of a tree contain a point, or are nearest to it.
#ifndef DUET_POINT_QUERY_H
#define DUET_POINT_QUERY_H

#include "duet_tree.h"

DUET_C_BEGIN

typedef struct duet_point {
    float at[3]; // in 2D z is not read
} duet_point;

// A point far from 0: at cell * edge + point.at, as a duet_large_pose.
typedef struct duet_large_point {
    duet_point point;
    int32_t cell[3];
} duet_large_point;

// docs/accuracy.md, "Points", bounds the error of distance.
typedef struct duet_point_hit {
    uint32_t point;
    uint32_t id;    // id of the box; DUET_NO_OBJECT: the tree has no more boxes
    float distance; // to the box, 0 inside
} duet_point_hit;

#define DUET_MOST_NEAREST 1024u

typedef struct duet_point_query duet_point_query;

typedef struct duet_point_query_def {
    duet_tree *tree;  // held until the query is destroyed
    uint32_t nearest; // finds so many nearest boxes of each point, at most DUET_MOST_NEAREST;
                      // 0: the boxes that contain it
    const duet_filter *filter; // filter of the points; copied. NULL: finds every object
    int cookie;
} duet_point_query_def;

DUET_API duet_point_query_def duet_default_point_query_def(void); // nearest 0

typedef struct duet_point_query_result {
    const duet_point_hit *hits; // [n_hits] the query's, until its next call
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // time of each device's part
} duet_point_query_result;

// Creates a query and builds its kernels.
DUET_API duet_point_query *duet_point_query_create(const duet_point_query_def *def,
                                                   duet_error *err);
DUET_API void duet_point_query_destroy(duet_point_query *query);

// Finds the boxes of n points, fewer than 2^32. Which boxes contain a point is exact, their faces
// included; these hits come by point and id. Nearest boxes are `nearest` hits a point, by distance
// and id. Hits are the same on every device and at every share. BAD_OBJECT names the first
// point that is not finite or above 2^100.
DUET_API bool duet_point_query_run(duet_point_query *query, const duet_point *points, uint64_t n,
                                   duet_point_query_result *result, duet_error *err);

// The same for a tree in origin cells. Points are rounded to 2^-24 of a cell's edge.
DUET_API bool duet_point_query_run_large(duet_point_query *query, const duet_large_point *points,
                                         uint64_t n, duet_point_query_result *result,
                                         duet_error *err);

DUET_C_END

#endif
