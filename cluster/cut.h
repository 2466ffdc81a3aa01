// SPDX-License-Identifier: MIT
// Cuts the world into a part for each rank: boxes that hold objects in proportion to the ranks'
// weights.
//
// The cut is made from a sample of the centres, each standing for as many objects. Unlike cells
// of one size, a sample is as fine where objects are dense as it must be, however far apart
// they lie, and its size does not grow with theirs.
#ifndef CLUSTER_CUT_H
#define CLUSTER_CUT_H

#include "cluster/bisection.h"
#include "cluster/objects.h"
#include "cluster/ranks.h"

typedef struct cut {
    bisection parts;           // one for each rank
    double *weights;           // [n of ranks], of which the greatest is 1
    double due;                // this rank's part of all objects
    double lower[3], upper[3]; // of this rank's part
} cut;

// Collective, as all here but cut_home and cut_keeps. weight is this rank's.
bool cut_begin(cut *c, ranks *r, double weight, duet_error *err);
void cut_end(cut *c);

// Weights are from here on what this says: how much each rank does in a time. False, and as they
// were, where a rank's is 0. The next cut is by them.
bool cut_weigh(cut *c, ranks *r, double speed);

// Cuts anew for the objects that the ranks hold, wherever these lie.
bool cut_make(cut *c, ranks *r, const object_form *form, const object_rows *rows, duet_error *err);

// Centres of at most n of the rows, evenly over them: [return]. Space for n.
uint32_t cut_sample(bisection_point *points, uint64_t n, const object_form *form,
                    const object_rows *rows);

// The rank whose part a point lies in.
static inline int cut_home(const cut *c, const double centre[3])
{
    return (int)bisection_part(&c->parts, centre);
}

// Where this rank's homes are.
static inline reach cut_box(const cut *c)
{
    return (reach){{c->lower[0], c->lower[1], c->lower[2]},
                   {c->upper[0], c->upper[1], c->upper[2]}};
}

// Whether that is this rank.
static inline bool cut_keeps(const cut *c, const double centre[3])
{
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside = inside && centre[k] >= c->lower[k] && centre[k] < c->upper[k];
    return inside;
}

#endif
