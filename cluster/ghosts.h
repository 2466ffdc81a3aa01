// SPDX-License-Identifier: MIT
// Ghosts: objects of other ranks that this rank's homes may touch, and whose pairs with them
// this rank finds. Exact whatever the objects' sizes: no width is chosen.
#ifndef CLUSTER_GHOSTS_H
#define CLUSTER_GHOSTS_H

#include "cluster/homes.h"

// The messages that arrive become *in. Collective; ok: whether this rank is well.
bool ghosts_exchange(const homes *h, ranks *r, bool ok, parcels *in, duet_error *err);

#endif
