// SPDX-License-Identifier: MIT
// A step of a rank with one part whose homes are searched while ghosts are on their way. No pair
// of two homes needs a ghost. When ghosts have come, they and the homes that may touch any, copied
// side by side, are searched by a second worker, and of its pairs those with a ghost are taken.
//
// That is for devices with memory of their own: they search while the host's processors exchange
// ghosts, where these are few beside the homes.
#ifndef CLUSTER_BORDER_H
#define CLUSTER_BORDER_H

#include "cluster/worker_search.h"

typedef struct border {
    worker *worker;      // the second one; NULL: it was not needed since the first one changed
    worker_search homes; // by the first one
    bool is_searching;   // homes, or they were searched and border_end is due
    bool done;           // the last step was of this kind
    object_rows rows;    // homes at the border, those that are gone, and the ghosts
    seen seen;           // these
    worker_found found;
} border;

struct duet_cluster;

// Begins to search the homes, which are settled, where that is worth it.
void border_begin(struct duet_cluster *c);

// Takes the ghosts that have come.
bool border_take_ghosts(struct duet_cluster *c, duet_error *err);

// Searches the border, waits for the homes, and takes the pairs of both; where not ok it waits.
bool border_end(struct duet_cluster *c, bool ok, duet_error *err);

void border_close(border *b);

#endif
