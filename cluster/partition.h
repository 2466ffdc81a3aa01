// SPDX-License-Identifier: MIT
// The partition of the world into a box for each rank, which hold objects in proportion to the
// ranks' weights.
//
// It is made from a sample of the centres, each standing for as many objects. Unlike cells
// of one size, a sample is as fine where objects are dense as it must be, however far apart
// they lie, and its size does not grow with theirs.
#ifndef CLUSTER_PARTITION_H
#define CLUSTER_PARTITION_H

#include "cluster/bisection.h"
#include "cluster/objects.h"
#include "cluster/parcels.h"

typedef struct partition {
    bisection parts; // one for each rank
    double *weights; // [n of ranks], of which the greatest is 1
    double due;      // this rank's part of all objects
    extent box;      // holds the centres of this rank's objects
} partition;

// weight is this rank's. Collective, as all calls here but partition_sample and partition_rank.
bool partition_begin(partition *p, ranks *r, double weight, duet_error *err);
void partition_end(partition *p);

// Makes the speeds of ranks, objects by time, the weights of the next partition. False, and weights
// are as they were, if a rank's is 0.
bool partition_weigh(partition *p, ranks *r, double speed);

// Partitions the world anew by the objects that ranks have, wherever these lie.
bool partition_make(partition *p, ranks *r, const object_form *form, const object_rows *rows,
                    duet_error *err);

// Writes the centres of at most n of the rows, evenly over them. Returns how many.
uint32_t partition_sample(bisection_point *points, uint64_t n, const object_form *form,
                          const object_rows *rows);

// Returns the rank whose box holds a point.
static inline int partition_rank(const partition *p, const double centre[3])
{
    return (int)bisection_part(&p->parts, centre);
}

#endif
