// SPDX-License-Identifier: MIT
// A rank's end of a cluster.
#ifndef CLUSTER_CLUSTER_H
#define CLUSTER_CLUSTER_H

#include "cluster/duet_cluster.h"
#include "cluster/found.h"

struct duet_cluster {
    duet_cluster_def def;       // with this rank's pair
    duet_device_pair *own_pair; // NULL: the caller's
    ranks ranks;
    cut cut;
    homes homes;
    worker *worker;
    seen seen;
    own_pairs own;
    uint64_t n_ghosts;
    bool changed; // objects, since the worker got them
    bool is_cold; // kernels may have to be built
    bool has_scene;
    duet_scene_info scene;
    char *scene_name;
    duet_cluster_rank last; // of this rank
};

// Takes the scene that rank 0 has read, on the others NULL; where `ok` is false there its err
// says why there is none.
bool cluster_take_scene(duet_cluster *c, bool ok, const duet_scene *scene, duet_error *err);

#endif
