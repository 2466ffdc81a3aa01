// SPDX-License-Identifier: MIT
// Hits on a tree's ground, which the host finds, among those on its objects.
#ifndef RUNTIME_GROUND_HITS_H
#define RUNTIME_GROUND_HITS_H

#include "runtime/queries/tree_query.h"

// Adds those of a run's n items to what the devices found. A tree without a ground, and a query
// that finds none, change nothing.
bool ground_hits_add(tree_query *q, uint64_t n, query_result *found, duet_error *err);

#endif
