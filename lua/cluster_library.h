// SPDX-License-Identifier: MIT
// The calls of libduet_cluster, which is loaded when a script asks for its first cluster: nothing
// else of this module knows MPI. That library holds all of Duet once more, so no object of ours
// may go into one of its calls: only numbers, texts, and rows.
#ifndef LUA_CLUSTER_LIBRARY_H
#define LUA_CLUSTER_LIBRARY_H

#include "cluster/duet_cluster.h"

typedef struct cluster_library {
    const char *(*version)(void);
    duet_cluster_def (*default_def)(void);
    duet_cluster *(*create)(const duet_cluster_def *, duet_error *);
    void (*destroy)(duet_cluster *);
    int (*get_rank)(const duet_cluster *);
    int (*get_rank_count)(const duet_cluster *);
    bool (*load_scene)(duet_cluster *, const char *, const duet_setting *, uint32_t, duet_error *);
    const duet_scene_info *(*get_scene_info)(const duet_cluster *);
    bool (*set_objects)(duet_cluster *, duet_object_kind, const uint64_t *, const void *, uint32_t,
                        duet_error *);
    void *(*map_homes)(duet_cluster *, duet_object_kind, const uint64_t **, uint32_t *,
                       duet_error *);
    bool (*set_plan)(duet_cluster *, const duet_plan *, duet_error *);
    bool (*load_profile)(duet_cluster *, const char *, duet_profile *, duet_error *, duet_error *);
    bool (*set_level)(duet_cluster *, duet_level, duet_error *);
    bool (*step)(duet_cluster *, duet_cluster_result *, duet_error *);
    bool (*get_own_pairs)(duet_cluster *, const duet_pair64 **, uint64_t *, duet_error *);
    bool (*get_ranks)(duet_cluster *, duet_cluster_rank *, duet_error *);
    bool (*save_pairs)(duet_cluster *, const char *, bool, duet_error *);
} cluster_library;

// The process's. NULL with NOT_FOUND where there is none, or one of another version.
const cluster_library *cluster_library_load(duet_error *err);

#endif
