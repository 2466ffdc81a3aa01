// SPDX-License-Identifier: MIT
// Which boxes of a tree contain a point, or are nearest to it.
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

// distance: to the box, 0 inside. Of its error docs/accuracy.md, "Points".
typedef struct duet_point_hit {
    uint32_t point;
    uint32_t id; // of the box; DUET_NO_OBJECT: the tree has no more boxes
    float distance;
} duet_point_hit;

#define DUET_MOST_NEAREST 1024u

typedef struct duet_point_query duet_point_query;

typedef struct duet_point_query_def {
    duet_tree *tree;  // held until the query is destroyed
    uint32_t nearest; // so many of the nearest boxes of each point, at most DUET_MOST_NEAREST;
                      // 0: those that contain it
    const duet_filter *filter; // of its points; copied. NULL: every object is found
    int cookie;
} duet_point_query_def;

DUET_API duet_point_query_def duet_default_point_query_def(void); // those that contain it

typedef struct duet_point_query_result {
    const duet_point_hit *hits; // [n_hits] the query's, until its next call
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // of each device's part
} duet_point_query_result;

// Builds the kernels that it needs.
DUET_API duet_point_query *duet_point_query_create(const duet_point_query_def *def,
                                                   duet_error *err);
DUET_API void duet_point_query_destroy(duet_point_query *query);

// Asks about n points, fewer than 2^32. Which boxes contain a point is exact, their faces
// included; those hits come by point and id. Nearest ones are `nearest` a point, by distance
// and id. All are the same on every device and at every share. BAD_OBJECT names the first
// point that is not a number or above 2^100.
DUET_API bool duet_point_query_run(duet_point_query *query, const duet_point *points, uint64_t n,
                                   duet_point_query_result *result, duet_error *err);

// The same for a tree in origin cells. A point is at the nearest 2^-24 of a cell's edge.
DUET_API bool duet_point_query_run_large(duet_point_query *query, const duet_large_point *points,
                                         uint64_t n, duet_point_query_result *result,
                                         duet_error *err);

DUET_C_END

#endif
