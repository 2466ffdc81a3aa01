// SPDX-License-Identifier: MIT
// Cuts the world into a part for each rank: boxes that hold objects in proportion to the ranks'
// weights.
//
// The cut is made from a sample of the centres, each standing for as many objects. Unlike cells
// of one size, a sample is as fine where objects are dense as it must be, however far apart
// they lie, and its size does not grow with theirs.
#ifndef CLUSTER_PARTITION_H
#define CLUSTER_PARTITION_H

#include "cluster/bisection.h"
#include "cluster/objects.h"
#include "cluster/ranks.h"

typedef struct partition {
    bisection parts;           // one for each rank
    double *weights;           // [n of ranks], of which the greatest is 1
    double due;                // this rank's part of all objects
    double lower[3], upper[3]; // of this rank's part
} partition;

// Collective, as all here but partition_rank and partition_keeps. weight is this rank's.
bool partition_begin(partition *p, ranks *r, double weight, duet_error *err);
void partition_end(partition *p);

// Weights are from here on what this says: how much each rank does in a time. False, and as they
// were, where a rank's is 0. The next cut is by them.
bool partition_weigh(partition *p, ranks *r, double speed);

// Cuts anew for the objects that the ranks hold, wherever these lie.
bool partition_make(partition *p, ranks *r, const object_form *form, const object_rows *rows, duet_error *err);

// Centres of at most n of the rows, evenly over them: [return]. Space for n.
uint32_t partition_sample(bisection_point *points, uint64_t n, const object_form *form,
                    const object_rows *rows);

// The rank whose part a point lies in.
static inline int partition_rank(const partition *p, const double centre[3])
{
    return (int)bisection_part(&p->parts, centre);
}

// Where this rank's homes are.
static inline reach partition_box(const partition *p)
{
    return (reach){{p->lower[0], p->lower[1], p->lower[2]},
                   {p->upper[0], p->upper[1], p->upper[2]}};
}

#endif
