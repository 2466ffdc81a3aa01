// SPDX-License-Identifier: MIT
// The world cut by planes into boxes, one for each part: in two across its widest side, each half
// in two again, until every part is alone. Each box holds points in proportion to its part's
// weight.
#ifndef CLUSTER_BISECTION_H
#define CLUSTER_BISECTION_H

#include "cluster/extent.h"
#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct bisection_point {
    double at[3];
    double weight;
} bisection_point;

// Parts below `part` lie below it along the axis; the one of that number, and what lies on the
// plane, do not.
typedef struct bisection_plane {
    double at;
    uint32_t axis;
} bisection_plane;

typedef struct bisection {
    uint32_t n;              // parts
    bisection_plane *planes; // [n]; planes[part], but the first
} bisection;

// Allocates n parts; all points are in the first part.
bool bisection_begin(bisection *b, uint32_t n, duet_error *err);
void bisection_end(bisection *b);

// Cuts anew, across the same sides as long as these are about as wide as any; the points change
// places. NULL weights, [n], are alike.
void bisection_cut(bisection *b, const double *weights, bisection_point *points, uint64_t n_points);

// Returns a part's box within another one: it holds points with lower <= centre < upper.
extent bisection_box(const bisection *b, uint32_t part, const extent *within);

static inline uint32_t bisection_part(const bisection *b, const double at[3])
{
    uint32_t first = 0, end = b->n;
    while (end - first > 1) {
        uint32_t middle = first + (end - first) / 2;
        const bisection_plane *plane = &b->planes[middle];
        if (at[plane->axis] < plane->at)
            end = middle;
        else
            first = middle;
    }
    return first;
}

#endif
