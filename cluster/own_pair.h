// SPDX-License-Identifier: MIT
// A rank's part of its host's devices.
#ifndef CLUSTER_OWN_PAIR_H
#define CLUSTER_OWN_PAIR_H

#include "cluster/duet_cluster.h"
#include "cluster/ranks.h"

// What def says, else DUET_PAIR where that is set. A rank alone on its host has the host's default
// pair. Of several ranks each has a GPU, the GPUs dealt out in turn; where there is none, an equal
// part of the CPU's units.
duet_device_pair *own_pair_open(const ranks *r, const duet_cluster_def *def, duet_error *err);

#endif
