// SPDX-License-Identifier: MIT
// Cuts the world into a part for each rank, by Zoltan's recursive bisection of coordinates:
// boxes that hold objects in proportion to the ranks' weights.
//
// The cut is made from a sample of the centres, each standing for as many objects. Unlike cells
// of one size, a sample is as fine where objects are dense as it must be, however far apart
// they lie, and its size does not grow with theirs.
#ifndef CLUSTER_CUT_H
#define CLUSTER_CUT_H

#include "cluster/objects.h"
#include "cluster/ranks.h"

struct Zoltan_Struct;

typedef struct cut {
    struct Zoltan_Struct *zoltan; // NULL for one rank
    bool is_made;                 // else all is rank 0's
    float *parts;                 // [n of ranks] of the work, which add up to 1
    double lower[3], upper[3];    // of this rank's part
} cut;

// Collective, as all here but cut_home. weight is this rank's.
bool cut_begin(cut *c, ranks *r, double weight, duet_error *err);
void cut_end(cut *c);

// Cuts anew for the objects that the ranks hold, wherever these lie.
bool cut_make(cut *c, ranks *r, const object_form *form, const object_rows *rows, duet_error *err);

// The rank whose part a point lies in. By one thread at a time.
int cut_home(const cut *c, const double centre[3]);

// True only where that is this rank; false too for what lies on its part's border.
static inline bool cut_surely_keeps(const cut *c, const double centre[3])
{
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside = inside && centre[k] > c->lower[k] && centre[k] < c->upper[k];
    return inside;
}

#endif
