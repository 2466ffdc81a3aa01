// SPDX-License-Identifier: MIT
// Workers without devices share this: their objects lie in plain memory, and plans and profiles,
// which are of devices, change nothing.
#ifndef CLUSTER_WORKER_HOST_H
#define CLUSTER_WORKER_HOST_H

#include "cluster/objects.h"
#include "cluster/worker.h"

typedef struct worker_host {
    worker base;
    object_form form;
    duet_level level;
    duet_plan plan; // which changes nothing
    void *objects;
    uint32_t n;
    uint64_t capacity; // objects for which there is memory
} worker_host;

// A worker of `bytes`, which begins with a worker_host; all else is 0. It needs a `find`, and ends
// by worker_host_close unless it has a `close` of its own. NULL with NO_MEMORY.
void *worker_host_open(size_t bytes, const char *name, const duet_world_def *def, duet_error *err);
void worker_host_close(worker *w);

#endif
