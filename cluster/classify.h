// SPDX-License-Identifier: MIT
// Classifies all objects that a rank owns: which domain they lie in, which leave the rank, and
// which of the others are boundary objects, that another domain's may touch. Most lie deep inside
// of the domain of the row before; they are passed over in bulk.
#ifndef CLUSTER_CLASSIFY_H
#define CLUSTER_CLASSIFY_H

#include "cluster/interior.h"
#include "cluster/owned.h"

// Holds what one thread finds.
typedef struct class_part {
    uint64_t n_bad;
    uint64_t first_bad; // the least id of these
    double widest;
    interior deep; // objects that were passed over
    row_list leavers;
    row_list boundary;
    run_list runs; // of several domains
} class_part;

typedef struct classes {
    class_part parts[PARALLEL_MOST]; // their lists' memory is used again
    uint64_t n_bad, first_bad;       // all of them together
    double widest;
    interior deep;
    row_list leavers; // ascending
} classes;

// Writes c's leavers and o's boundary, runs, boxes and around. A device does it if the rows are on
// their way to one that can; else the host's threads. Before rows are placed nothing leaves. False
// without memory for the lists, which still count.
bool classify(classes *c, owned *o);
void classes_end(classes *c);

#endif
