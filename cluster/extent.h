// SPDX-License-Identifier: MIT
// Boxes with faces along the axes.
#ifndef CLUSTER_EXTENT_H
#define CLUSTER_EXTENT_H

#include "base/compare.h"

#include <math.h>
#include <stdbool.h>

typedef struct extent {
    double lower[3];
    double upper[3];
} extent;

static const extent extent_none = {{INFINITY, INFINITY, INFINITY},
                                   {-INFINITY, -INFINITY, -INFINITY}}; // contains nothing
static const extent extent_all = {{-INFINITY, -INFINITY, -INFINITY},
                                  {INFINITY, INFINITY, INFINITY}};

// A box as devices have it: lower xyz, upper xyz.
static inline extent extent_of_box(const float box[6])
{
    return (extent){{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
}

static inline double extent_widest(const extent *e)
{
    double widest = greater(e->upper[0] - e->lower[0], e->upper[1] - e->lower[1]);
    return greater(widest, e->upper[2] - e->lower[2]);
}

static inline void extent_join(extent *to, const extent *other)
{
    for (int k = 0; k < 3; ++k) {
        to->lower[k] = lesser(to->lower[k], other->lower[k]);
        to->upper[k] = greater(to->upper[k], other->upper[k]);
    }
}

static inline void extent_add(extent *to, const double point[3])
{
    for (int k = 0; k < 3; ++k) {
        to->lower[k] = lesser(to->lower[k], point[k]);
        to->upper[k] = greater(to->upper[k], point[k]);
    }
}

static inline extent extent_grown(extent e, double by)
{
    for (int k = 0; k < 3; ++k) {
        e.lower[k] -= by;
        e.upper[k] += by;
    }
    return e;
}

static inline bool extents_meet(const extent *a, const extent *b)
{
    bool meet = true;
    for (int k = 0; k < 3; ++k)
        meet &= (a->lower[k] <= b->upper[k]) & (b->lower[k] <= a->upper[k]);
    return meet;
}

static inline bool extent_within(const extent *inner, const extent *outer)
{
    bool within = true;
    for (int k = 0; k < 3; ++k)
        within &= (inner->lower[k] >= outer->lower[k]) & (inner->upper[k] <= outer->upper[k]);
    return within;
}

// Whether what lay in one box and is in another now moved so far that a grid fitted to it pays to
// be fitted anew: by a quarter of the width that it took, on any side.
static inline bool extent_has_moved(const extent *fitted, const extent *now)
{
    bool moved = false;
    for (int k = 0; k < 3; ++k) {
        const double far = 0.25 * (fitted->upper[k] - fitted->lower[k]);
        moved = moved || fabs(now->lower[k] - fitted->lower[k]) > far ||
                fabs(now->upper[k] - fitted->upper[k]) > far;
    }
    return moved;
}

// Whether a point lies inside, and not on the surface.
static inline bool extent_holds(const extent *e, const double point[3])
{
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside &= (point[k] > e->lower[k]) & (point[k] < e->upper[k]);
    return inside;
}

#endif
