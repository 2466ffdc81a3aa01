// SPDX-License-Identifier: MIT
// Clusters: the objects of a world, divided among the ranks of an MPI job. Each rank has a
// device pair of its own, and all ranks together find the pairs that one world would find.
//
// All calls are collective: every rank makes the same calls in the same order. Each ends on all
// ranks in the same way; if it fails on one rank, all return false with that rank's line, which
// begins with the rank and its host. If ranks make different calls, each of these calls fails with
// BAD_ARGUMENT and the cluster is as before; only create waits until all ranks of its comm create
// one, and destroy until all destroy it. Getters and destroy's argument NULL are a rank's own. One
// thread of a rank calls MPI.
//
// A global id is 64 bits. A rank owns the objects in its part of the world; its ghosts are objects
// of other ranks that these may touch. Which rank owns an object never changes a result.
#ifndef DUET_CLUSTER_H
#define DUET_CLUSTER_H

#include "duet_motion_commands.h"

DUET_C_BEGIN

typedef struct duet_cluster duet_cluster;

typedef struct duet_cluster_def {
    void *comm; // an MPI_Comm *, of which a copy is used. NULL: MPI_COMM_WORLD; if MPI was not
                // begun, create begins it and destroy ends it
    duet_world_def world; // the same on all ranks, except pair and plan. has_accuracy, keep_bad,
                          // pose_form is refused; max_pairs holds for
                          // each rank, ghosts' pairs included
    const char *pair;     // this rank's devices if world.pair is NULL, as duet_device_pair_def.a
                          // has them. NULL: DUET_PAIR, or else this rank's part of its host: a GPU,
                          // or of the CPU's units
    bool plain;           // no devices: pairs are found by the plain C reference
    double weight;        // this rank's part of all objects is weight by the sum of all ranks'
                          // weights. 0, on all ranks: weights are what load_profile finds, and
                          // until then all alike; then the times that steps take, if these are so
                          // unequal that a partition pays
    uint32_t parts;       // parts in which this rank's devices see its owned objects, one after the
                          // other: the devices need memory for two parts. 1, up to 1024
    bool drops_pairs; // pairs are only counted and hashed. If false, pairs can be asked for, which
                      // costs nothing until then; but several parts list them as each part is
                      // searched
    double imbalance; // the partition is made anew if a rank has this many times the objects that
                      // are due to it; above 1
    duet_compile_callback *on_compile; // called for a pair that is taken if world.pair is NULL
    void *context;                     // handed to it
    int cookie;
} duet_cluster_def;

DUET_API duet_cluster_def duet_default_cluster_def(void);

DUET_API duet_cluster *duet_cluster_create(const duet_cluster_def *def, duet_error *err);
DUET_API void duet_cluster_destroy(duet_cluster *cluster);

DUET_API int duet_cluster_get_rank(const duet_cluster *cluster);       // from 0; -1 for NULL
DUET_API int duet_cluster_get_rank_count(const duet_cluster *cluster); // 0 for NULL

// Reads a scene as duet_scene_load does: rank 0 reads it, and the others need not have the file. If
// `each` makes the objects, every rank reads the scene and makes its part of them; if all ranks
// have the same .npy file, each reads its rows of it. Dims, shape, rotated, cell, origin_edge and
// level of all ranks' worlds become the scene's.
DUET_API bool duet_cluster_load_scene(duet_cluster *cluster, const char *path,
                                      const duet_setting *settings, uint32_t n_settings,
                                      duet_error *err);
// Returns the info of the loaded scene, on every rank; NULL if none was loaded. n counts the
// objects of all ranks.
DUET_API const duet_scene_info *duet_cluster_get_scene_info(const duet_cluster *cluster);

// Copies n objects of this rank's choice, with their global ids, of the kind that the worlds were
// made for. All ranks' objects together replace the old objects; BAD_ARGUMENT if an id is there
// twice, and the old objects stay. If ranks' ids overlap as ranges, each id travels once for that
// check.
DUET_API bool duet_cluster_set_objects(duet_cluster *cluster, duet_object_kind kind,
                                       const uint64_t *ids, const void *objects, uint32_t n,
                                       duet_error *err);

// Returns this rank's owned objects, to be written in place, and their ids, in no order: which
// object a row is may change with each step. The rows are valid until the next call but a getter.
// If parts is 1, the devices read this memory without a copy. Objects that leave their rank's box
// change owners in the next step. After BAD_OBJECT all owned objects are there as they were, to be
// mended.
DUET_API void *duet_cluster_map_owned(duet_cluster *cluster, duet_object_kind kind,
                                      const uint64_t **ids, uint32_t *n, duet_error *err);

// Sets the plan of this rank's devices; plans may differ from rank to rank. If one rank's devices
// cannot have its plan, all ranks keep the plan they had.
DUET_API bool duet_cluster_set_plan(duet_cluster *cluster, const duet_plan *plan, duet_error *err);
// Gives each rank the best plan known for its devices and its number of objects; profile is this
// rank's. If weights are 0 and the time of a step is known for all ranks, each rank gets objects in
// proportion to its speed. If the cluster has a motion, profile is rank 0's on all ranks: the
// colours after which ghosts come, as `duet cluster --tune-colours` found them on as many ranks,
// parts and hosts. path is duet_world_load_profile's. A store that cannot be read is no failure:
// the plan stays, and store_failed, which may be NULL, says why on that rank.
DUET_API bool duet_cluster_load_profile(duet_cluster *cluster, const char *path,
                                        duet_profile *profile, duet_error *store_failed,
                                        duet_error *err);
// Sets the level, the same on all ranks; if one of them cannot have it, all keep the level they
// had.
DUET_API bool duet_cluster_set_level(duet_cluster *cluster, duet_level level, duet_error *err);

// A collision between objects a < b, by their global ids.
typedef struct duet_pair64 {
    uint64_t a;
    uint64_t b;
} duet_pair64;

typedef struct duet_cluster_result {
    uint64_t objects; // the sum over all ranks, as are
    uint64_t pairs;
    uint64_t hash;   // the pair hash: duet_result_get_hash of one world with these objects. If an
                     // id is 2^32 or more, k is made of the lower 32 bits, and before anything else
                     // k ^= mixed(a >> 32 << 32 | b >> 32), as k itself is mixed
    double total_ms; // wall clock of the rank that took longest
} duet_cluster_result;

// Finds all pairs. BAD_OBJECT names the least id of an object that is NaN, infinite, negative
// or without rotation; otherwise it fails as duet_world_step does.
DUET_API bool duet_cluster_step(duet_cluster *cluster, duet_cluster_result *result,
                                duet_error *err);

// Returns the pairs of the last step that this rank found, in no order; each pair is one rank's.
// The call is a rank's own, before objects are mapped, set or loaded again; BAD_ARGUMENT after
// that, and if pairs are dropped. Devices that kept the pairs bring them now, if they were not
// asked before. The cluster owns the array, which is valid until the next step, or other objects.
DUET_API bool duet_cluster_get_own_pairs(duet_cluster *cluster, const duet_pair64 **pairs,
                                         uint64_t *n, duet_error *err);

// Says what a rank did in the last step.
typedef struct duet_cluster_rank {
    char host[64];
    char pair[132];      // selectors of its devices, "A,B", or of the one; "plain": none
    uint64_t objects;    // that it owns
    uint64_t ghosts;     // objects of other ranks that it received
    uint64_t pairs;      // that it found
    uint64_t sent_bytes; // to other ranks
    double busy_ms;
    double wait_ms; // waited for other ranks, and for what they sent
} duet_cluster_rank;

// Fills a row for each rank, ranks[duet_cluster_get_rank_count].
DUET_API bool duet_cluster_get_ranks(duet_cluster *cluster, duet_cluster_rank *ranks,
                                     duet_error *err);

// Writes all ranks' own pairs as a NumPy array of uint64, (pairs, 2), by all ranks at once; the
// path must lead to the same file on all hosts. The file appears whole or not at all. With sorted
// the pairs ascend, and its bytes are the same at any number of ranks.
DUET_API bool duet_cluster_save_pairs(duet_cluster *cluster, const char *path, bool sorted,
                                      duet_error *err);

// ---------------------------------------------------------------- motion

// Reads a scene whose bodies move, on rank 0, and divides them among the ranks' domains (parts of
// the def each). Each rank's devices hold its domains' bodies and their ghosts. Replaces the motion
// that the cluster had; other objects stay as they are. BAD_ARGUMENT for a cluster without devices.
// resume NULL: the scene's beginning; else a file of duet_cluster_save_motion, of the same scene
// and any number of ranks, which rank 0 reads.
// If the def's plan does not say how often ghosts come (motion.colours), steps try some numbers
// until a profile says it (duet_cluster_load_profile).
DUET_API bool duet_cluster_begin_motion(duet_cluster *cluster, const char *path,
                                        const duet_setting *settings, uint32_t n_settings,
                                        const char *resume, duet_error *err);

// Returns how many steps the motion has taken, those before a file that it goes on from included;
// 0: nothing moves. A program that is started again after a crash advances until this is its last
// step.
DUET_API uint64_t duet_cluster_get_motion_step(const duet_cluster *cluster);

typedef struct duet_cluster_motion_result {
    uint64_t step;     // how many were taken, the last one included
    uint64_t bodies;   // the sum over all ranks, as are
    uint64_t ghosts;   // bodies that domains have of others
    uint64_t contacts; // that push
    uint32_t colours;
    double total_ms;          // wall clock of the rank that took longest
    double slowest_ms;        // that the rank was busy that was so longest,
    double mean_ms;           // and the mean rank: on CPUs, processor time
    uint32_t slowest_rank;    // of steps before, which ranks compare after each eight
    const duet_event *events; // [n_events] this rank's, by global ids; ascending, as are the others
    uint64_t n_events;
    const duet_pair *stays; // [n_stays]
    uint64_t n_stays;
    const duet_hit_event *hits; // [n_hits]
    uint64_t n_hits;
} duet_cluster_motion_result;

// Takes a time step. Bodies have the same bits at any number of ranks and parts as those of one
// duet_motion, and the ranks' events, stays and hits together are that one's: each is told by one
// rank. Their memory is the cluster's until the next call that changes the motion. After a failure
// the motion is gone.
DUET_API bool duet_cluster_advance(duet_cluster *cluster, duet_cluster_motion_result *result,
                                   duet_error *err);

// ---------------------------------------------------------------- commands

// The commands to a motion between its steps (duet_motion_commands.h, which says what each does),
// by global ids. Rank 0's arguments are all ranks', and those of others may be NULL or 0; ids and
// data are filled on each rank, as many as its own n says. The next step has the bits of a motion
// that was given the same commands. If one fails with BAD_ARGUMENT or BAD_OBJECT, nothing has
// changed; after another failure the motion is gone. With depenetration the first step comes before
// them.
DUET_API bool duet_cluster_add_bodies(duet_cluster *cluster, const duet_pose *poses,
                                      const duet_body *bodies, uint32_t n, uint64_t *ids,
                                      duet_error *err);
DUET_API bool duet_cluster_remove_bodies(duet_cluster *cluster, duet_body_list list,
                                         duet_error *err);
DUET_API bool duet_cluster_disable_bodies(duet_cluster *cluster, duet_body_list list,
                                          duet_error *err);
DUET_API bool duet_cluster_enable_bodies(duet_cluster *cluster, duet_body_list list,
                                         duet_error *err);
DUET_API bool duet_cluster_wake_bodies(duet_cluster *cluster, duet_body_list list, duet_error *err);
DUET_API bool duet_cluster_sleep_bodies(duet_cluster *cluster, duet_body_list list,
                                        duet_error *err);
DUET_API bool duet_cluster_set_bodies(duet_cluster *cluster, duet_body_list list, uint32_t fields,
                                      const duet_body *bodies, duet_error *err);
DUET_API bool duet_cluster_set_poses(duet_cluster *cluster, duet_body_list list,
                                     const duet_pose *poses, duet_error *err);
DUET_API bool duet_cluster_set_targets(duet_cluster *cluster, duet_body_list list,
                                       const duet_transform *targets, duet_error *err);
DUET_API bool duet_cluster_apply_forces(duet_cluster *cluster, duet_body_list list,
                                        const duet_force *forces, duet_error *err);
DUET_API bool duet_cluster_apply_impulses(duet_cluster *cluster, duet_body_list list,
                                          const duet_impulse *impulses, duet_error *err);
DUET_API bool duet_cluster_set_user_data(duet_cluster *cluster, duet_body_list list,
                                         const uint64_t *data, duet_error *err);
DUET_API bool duet_cluster_get_user_data(duet_cluster *cluster, duet_body_list list, uint64_t *data,
                                         duet_error *err);

// The motion's def, whose pair, plan and ground are this rank's; NULL: nothing moves. A def that is
// set is rank 0's, changed in what duet_motion_set_def may change.
DUET_API const duet_motion_def *duet_cluster_get_motion_def(const duet_cluster *cluster);
DUET_API bool duet_cluster_set_def(duet_cluster *cluster, const duet_motion_def *def,
                                   duet_error *err);

// ---------------------------------------------------------------- a motion's state

// Makes *hash that of duet_motion_get_hash, of all ranks' bodies.
DUET_API bool duet_cluster_get_state_hash(duet_cluster *cluster, uint64_t *hash, duet_error *err);

// Writes the motion as duet_motion_save does, without a skin: the file's bytes are the same for any
// number of ranks and parts. Rank 0 writes it, and needs memory for all bodies. The file appears
// whole or not at all.
DUET_API bool duet_cluster_save_motion(duet_cluster *cluster, const char *path, duet_error *err);

DUET_C_END

#endif
