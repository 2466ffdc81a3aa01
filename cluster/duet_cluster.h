// SPDX-License-Identifier: MIT
// Clusters: the objects of a world, divided among the ranks of an MPI job. Each rank has a
// device pair of its own, and all ranks together find the pairs that one world would find.
//
// All calls are collective: every rank makes the same calls in the same order. Each ends on
// all ranks in the same way; where it fails on one, all return false with that rank's line,
// which begins with the rank and its host. Where ranks make different calls, each of these fails
// with BAD_ARGUMENT and the cluster is as before; only create waits until all ranks of its comm
// create one, and destroy until all destroy it.
// Getters and destroy's argument NULL are a rank's own. One thread of a rank calls MPI.
//
// A global id is 64 bits. A rank's homes are the objects that it owns; its ghosts are objects of
// others that its homes may touch. Which rank owns an object never changes a result.
#ifndef DUET_CLUSTER_H
#define DUET_CLUSTER_H

#include "duet_world.h"

DUET_C_BEGIN

typedef struct duet_cluster duet_cluster;

typedef struct duet_cluster_def {
    void *comm; // an MPI_Comm *, of which a copy is used. NULL: MPI_COMM_WORLD; where MPI was
                // not begun, create begins it and destroy ends it
    duet_world_def world; // the same on all ranks, except pair and plan. has_accuracy, keep_bad,
                          // separate_sizes and compact_transforms are refused; max_pairs is of
                          // each rank, ghosts' pairs included
    const char *pair;     // where world.pair is NULL: a rank's devices, as duet_device_pair_def.a
                          // has them. NULL: DUET_PAIR, or else this rank's part of its host: a
                          // GPU, or of the CPU's units
    bool plain;           // no devices: pairs are found by the plain C reference
    double weight;        // of this rank: it gets this part of all ranks' sum. 0, on all ranks:
                          // what load_profile finds, and until then all are alike; then the
                          // times that steps take, where these are so unequal that a cut pays
    uint32_t parts;   // in which this rank's devices see its homes, one after the other: they need
                      // memory for two of them. 1, up to 1024
    bool drops_pairs; // pairs are only counted and hashed. Without it they can be asked for, which
                      // costs nothing until they are; but with several parts they are listed as
                      // each part is searched
    double imbalance; // the cut is made anew where a rank has this many times the objects
                      // that are due to it; above 1
    duet_compile_callback *on_compile; // of a pair that is taken where world.pair is NULL
    void *context;                     // handed to it
    int cookie;
} duet_cluster_def;

DUET_API duet_cluster_def duet_default_cluster_def(void);

DUET_API duet_cluster *duet_cluster_create(const duet_cluster_def *def, duet_error *err);
DUET_API void duet_cluster_destroy(duet_cluster *cluster);

DUET_API int duet_cluster_get_rank(const duet_cluster *cluster);       // from 0; -1 for NULL
DUET_API int duet_cluster_get_rank_count(const duet_cluster *cluster); // 0 for NULL

// Reads a scene as duet_scene_load does: rank 0 reads it, and the others need not have the file.
// Only where objects are made by `each` every rank reads it, and makes its part of them; and where
// all have the same .npy file, each reads its rows of it. Dims, shape, rotated, cell, origin_edge
// and level of all ranks' worlds become the scene's.
DUET_API bool duet_cluster_load_scene(duet_cluster *cluster, const char *path,
                                      const duet_setting *settings, uint32_t n_settings,
                                      duet_error *err);
// What was loaded, on every rank; NULL where nothing was. n is that of all ranks.
DUET_API const duet_scene_info *duet_cluster_get_scene_info(const duet_cluster *cluster);

// Copies n objects of this rank's choice, with their global ids, of the kind that the worlds
// were made for. All ranks' objects together replace those that there were; BAD_ARGUMENT where an
// id is there twice, and the old ones stay. Where ranks' ids overlap as ranges each id travels once
// for that.
DUET_API bool duet_cluster_set_objects(duet_cluster *cluster, duet_object_kind kind,
                                       const uint64_t *ids, const void *objects, uint32_t n,
                                       duet_error *err);

// This rank's homes, to be written in place, and their ids, in no order: which object a row is
// may change with each step. Valid until the next call but a getter. With one part this is memory
// that the devices read without a copy. Objects that leave their rank's box change homes in the
// next step. After BAD_OBJECT all homes are there as they were, to be mended.
DUET_API void *duet_cluster_map_homes(duet_cluster *cluster, duet_object_kind kind,
                                      const uint64_t **ids, uint32_t *n, duet_error *err);

// Of this rank's devices; they may differ from rank to rank. Where one rank's cannot have theirs,
// all keep the one they had.
DUET_API bool duet_cluster_set_plan(duet_cluster *cluster, const duet_plan *plan, duet_error *err);
// Gives each rank the best plan known for its devices and its number of objects; profile is
// this rank's. Where weights are 0 and the time of a step is known for all ranks, each gets as many
// objects as it does while the others do theirs. path is duet_world_load_profile's. A store that
// cannot be read is no failure: the plan stays, and store_failed, which may be NULL, says why on
// that rank.
DUET_API bool duet_cluster_load_profile(duet_cluster *cluster, const char *path,
                                        duet_profile *profile, duet_error *store_failed,
                                        duet_error *err);
// The same on all ranks; where one of them cannot have it, all keep the one they had.
DUET_API bool duet_cluster_set_level(duet_cluster *cluster, duet_level level, duet_error *err);

// A collision between objects a < b, by their global ids.
typedef struct duet_pair64 {
    uint64_t a;
    uint64_t b;
} duet_pair64;

typedef struct duet_cluster_result {
    uint64_t objects; // of all ranks, as are
    uint64_t pairs;
    uint64_t hash;   // the pair hash: duet_result_get_hash of one world with these objects. Of
                     // ids from 2^32 on, k is made of the lower 32 bits, and before anything
                     // else k ^= mixed(a >> 32 << 32 | b >> 32), as k itself is mixed
    double total_ms; // wall clock of the rank that took longest
} duet_cluster_result;

// Finds all pairs. BAD_OBJECT names the least id of an object that is NaN, infinite, negative
// or without rotation; otherwise it fails as duet_world_step does.
DUET_API bool duet_cluster_step(duet_cluster *cluster, duet_cluster_result *result,
                                duet_error *err);

// The pairs of the last step that this rank found, in no order; each pair is one rank's. A rank's
// own call, before objects are mapped, set or loaded again; BAD_ARGUMENT after that, and where
// pairs are dropped. Devices that kept them bring them now, where they were not asked before. The
// array is the cluster's until the next step, or other objects.
DUET_API bool duet_cluster_get_own_pairs(duet_cluster *cluster, const duet_pair64 **pairs,
                                         uint64_t *n, duet_error *err);

// What a rank did in the last step.
typedef struct duet_cluster_rank {
    char host[64];
    char pair[132];      // selectors of its devices, "A,B", or of the one; "plain": none
    uint64_t objects;    // its homes
    uint64_t ghosts;     // objects of other ranks that it received
    uint64_t pairs;      // that it found
    uint64_t sent_bytes; // to other ranks
    double busy_ms;
    double wait_ms; // for other ranks, and for what they sent
} duet_cluster_rank;

// Fills a row for each rank, ranks[duet_cluster_get_rank_count].
DUET_API bool duet_cluster_get_ranks(duet_cluster *cluster, duet_cluster_rank *ranks,
                                     duet_error *err);

// Writes all ranks' own pairs as a NumPy array of uint64, (pairs, 2), by all ranks at once; the
// path must lead to the same file on all hosts. The file appears whole or not at all. With sorted
// the pairs ascend, and its bytes are the same at any number of ranks.
DUET_API bool duet_cluster_save_pairs(duet_cluster *cluster, const char *path, bool sorted,
                                      duet_error *err);

DUET_C_END

#endif
