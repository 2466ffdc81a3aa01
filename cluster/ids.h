// SPDX-License-Identifier: MIT
// Whether ranks that bring objects bring any id twice.
#ifndef CLUSTER_IDS_H
#define CLUSTER_IDS_H

#include "cluster/ranks.h"

// Each rank's ids ascend. Collective: all ranks get the same line, BAD_ARGUMENT, that names the
// least doubled id and two ranks that have it. If each rank has a range of its own, the ends of
// these ranges say so; else every id travels once.
bool ids_are_distinct(ranks *r, const uint64_t *ids, uint32_t n, duet_error *err);

#endif
