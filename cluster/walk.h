// SPDX-License-Identifier: MIT
// A look at homes in parts by which their pairs are found as well: each part is searched as it
// comes by, alone, while the next one is on its way to the devices, and what lies at its edges is
// kept. The pairs of two parts, and those with other ranks' objects, are all of two objects at
// edges: these are one more part. So the host reads the edges alone, and no part waits for the
// ghosts that the others have for it.
//
// That holds as long as no object has come farther out of the part that it lies in than any is
// wide. Where one has, or where a look finds anything else out of the ordinary, what was found
// counts for nothing, and parts are searched with their ghosts (cluster/parts.h).
#ifndef CLUSTER_WALK_H
#define CLUSTER_WALK_H

#include "cluster/found.h"
#include "cluster/look.h"

typedef struct walk {
    bool wanted;     // by the step that is to come
    uint32_t pauses; // so many steps go without, after one that was in vain
    bool done;       // only the edges are left to search
    edge_rows edges;
    uint32_t *keys; // of the ghosts among them
    uint32_t n_ghosts;
    uint64_t needed; // of edges, when they were last counted
    seen seen;
    global_ids ids[2];
    uint32_t *without;             // of the part that is searched
    uint64_t taken[PARALLEL_MOST]; // of each glance's leavers, by the parts before
} walk;

struct duet_cluster;

// What homes call (cluster/homes.h).
bool walk_parts(void *cluster, look *l);

// After that, when homes are settled: brings each to its part. False after an error; walk.done says
// whether what was found holds.
bool walk_settle(struct duet_cluster *c, duet_error *err);

// Searches the edges.
bool walk_end(struct duet_cluster *c, duet_error *err);

void walk_free(walk *w);

#endif
