// SPDX-License-Identifier: MIT
// A rank's end of a cluster.
#ifndef CLUSTER_CLUSTER_H
#define CLUSTER_CLUSTER_H

#include "cluster/balance.h"
#include "cluster/border.h"
#include "cluster/duet_cluster.h"
#include "cluster/ghosts.h"
#include "cluster/parts.h"
#include "cluster/walk.h"

struct duet_cluster {
    duet_cluster_def def;       // with this rank's pair
    duet_device_pair *own_pair; // NULL: the caller's
    ranks ranks;
    parallel threads;
    cut cut;
    homes homes;
    balance balance;
    ghosts ghosts;
    parts parts;
    walk walk;
    border border;
    worker *workers[2]; // one is filled while the other finds; the second is of several parts
    seen seen[2];
    uint32_t filled[2]; // by which part, from 1; 0: it has to be
    reach fitted;       // around the homes, when workers were last told that they moved
    own_pairs own;
    worker_found found; // in the only part, where is_found; without what border found
    bool is_found;      // it is of the objects as they are
    uint64_t n_ghosts;
    bool changed;    // objects, since the worker got them
    bool is_stopped; // a rank was asked to stop before the last step ended, which is known to all
    bool is_cold;    // kernels may have to be built
    bool has_scene;
    duet_scene_info scene;
    char *scene_name;
    duet_cluster_rank last; // of this rank
};

// duet_cluster_create of simulated ranks; s, unless NULL, has to stay.
duet_cluster *cluster_create(const duet_cluster_def *def, const simulation *s, duet_error *err);

// Makes c->own list this rank's pairs of the last step; not collective.
bool cluster_list_pairs(duet_cluster *c, duet_error *err);

// duet_cluster_load_scene. With `whole` rank 0 reads all of the scene and hands it over, to be
// destroyed; the others get NULL.
bool cluster_load_scene(duet_cluster *c, const char *path, const duet_setting *settings,
                        uint32_t n_settings, duet_scene **whole, duet_error *err);

// ---------------------------------------------------------------- of its own files

// Two where one is filled while the other searches.
static inline int cluster_workers(const duet_cluster *c)
{
    return c->parts.n > 1 ? 2 : 1;
}

// Where objects lie elsewhere than before, workers are told.
void cluster_follow(duet_cluster *c);
worker *cluster_open_worker(const duet_cluster *c, const duet_world_def *world, duet_error *err);
// As many as it has, for such worlds: all or none.
bool cluster_open_workers(const duet_cluster *c, const duet_world_def *world, worker *workers[2],
                          duet_error *err);
void cluster_close_workers(worker *workers[2]);
// These in the place of those that there were, and without objects.
void cluster_take_workers(duet_cluster *c, const duet_world_def *world, worker *workers[2]);
// These objects, in the place of those that there were.
void cluster_take(duet_cluster *c, object_rows *rows);
// A call's failure on one rank, NULL arguments included, becomes that of all.
bool cluster_agree_on(duet_cluster *c, const char *call, bool ok, duet_error *own, duet_error *err);
// Rows that change places are no longer those that pairs were found of.
void cluster_forget_found(duet_cluster *c);
// What a worker is told of homes in any order.
global_ids cluster_ids_of_homes(const duet_cluster *c);
// This rank's pairs become those of what was found in its only part, and at its border.
bool cluster_take_found(duet_cluster *c, bool lists, duet_error *err);
// All objects are where they belong: on all ranks, or on none.
bool cluster_settle_all(duet_cluster *c, const char *call, bool ok, duet_error *own,
                        duet_error *err);

#endif
