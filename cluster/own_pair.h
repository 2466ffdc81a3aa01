// SPDX-License-Identifier: MIT
// A rank's part of its host's devices.
#ifndef CLUSTER_OWN_PAIR_H
#define CLUSTER_OWN_PAIR_H

#include "cluster/duet_cluster.h"
#include "cluster/ranks.h"

// Opens the pair that def names, else DUET_PAIR if that is set. A rank alone on its host gets the
// host's default pair. Several ranks get a GPU each, in turn; without a GPU, an equal part of the
// CPU's units.
duet_device_pair *own_pair_open(const ranks *r, const duet_cluster_def *def, duet_error *err);

#endif
