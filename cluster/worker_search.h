// SPDX-License-Identifier: MIT
// A worker that finds the pairs of what a rank sees, at once or beside what its caller does.
#ifndef CLUSTER_WORKER_SEARCH_H
#define CLUSTER_WORKER_SEARCH_H

#include "cluster/found.h"

typedef struct worker_search {
    worker *worker;
    const seen *seen;
    global_ids ids;
    bool tells_ids; // of homes that lie where the worker reads them
    worker_found found;
    duet_error err;
    bool ok;
    parallel *beside; // the threads of which one makes it; NULL: it is over
} worker_search;

// Of what the first four say, which stay until the end. beside: NULL for at once.
void worker_search_begin(worker_search *s, parallel *beside);
// Waits for it; false where it failed, or where the worker refuses an object.
bool worker_search_end(worker_search *s, duet_error *err);

#endif
