// SPDX-License-Identifier: MIT
// A worker that finds the pairs of what a rank sees, on a thread of its own where that is asked
// for and there is one.
#ifndef CLUSTER_WORKER_SEARCH_H
#define CLUSTER_WORKER_SEARCH_H

#include "cluster/found.h"

#include <pthread.h>

typedef struct worker_search {
    worker *worker;
    const seen *seen;
    global_ids ids;
    bool tells_ids; // of homes that lie where the worker reads them
    worker_found found;
    duet_error err;
    bool ok;
    bool is_apart; // on a thread of its own
    pthread_t thread;
} worker_search;

// Of what the first four say, which stay until the end.
void worker_search_begin(worker_search *s, bool apart);
// Waits for it; false where it failed, or where the worker refuses an object.
bool worker_search_end(worker_search *s, duet_error *err);

#endif
