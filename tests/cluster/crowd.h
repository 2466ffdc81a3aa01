// SPDX-License-Identifier: MIT
// Objects that the ranks of a job divide among them, and clusters of them.
#ifndef TESTS_CROWD_H
#define TESTS_CROWD_H

#include "cluster/job.h"

#include "base/rng.h"

enum { N_GROUPS = 5, MOST_OBJECTS = 300 };
extern const int groups[N_GROUPS]; // ranks of a cluster

// Objects of a test, the same on all ranks, and what the reference finds among them.
typedef struct crowd {
    duet_world_def world;
    uint32_t n;
    char name[64];
    duet_pose poses[MOST_OBJECTS];
    duet_bounds bounds[MOST_OBJECTS];
    duet_large_pose large[MOST_OBJECTS];
    duet_rounded_box rounded[MOST_OBJECTS];
    duet_sphere spheres[MOST_OBJECTS];
    duet_pair *pairs;
    uint64_t n_pairs;
} crowd;

enum { SPHERES = 43, ROUNDED = 45, N_CROWDS = 55 }; // crowds from SPHERES on have radii

// Makes crowd i, some of whose objects touch on a lattice, are huge, or far away.
void make_crowd(crowd *c, rng *r, uint32_t i);

duet_object_kind kind_of(const crowd *c);
const void *objects_of(const crowd *c);
float *row_of(const crowd *c, uint64_t id);

// Finds the pairs by the reference, on rank 0 for all of the job.
void find_expected(crowd *c);
uint64_t hash_of(const crowd *c);

// ---------------------------------------------------------------- clusters

extern uint32_t n_parts; // of the clusters that are opened

// NULL on ranks beyond n_ranks.
duet_cluster *open_cluster(int n_ranks, const duet_world_def *world, double weight);

// Each object is some rank's to bring, at random: `salt` says whose.
void hand_over(duet_cluster *cluster, const crowd *c, uint64_t first_id, uint32_t salt);

duet_cluster_result step(duet_cluster *cluster);

// Steps, and finds the crowd's pairs.
void must_find(duet_cluster *cluster, const crowd *c);

// Gives domains any planes at all, or some of a lattice, the same on all ranks of the group.
void deal_anew(duet_cluster *cluster, bool on_lattice, rng *r);

// ---------------------------------------------------------------- facts

// A fact about a cluster of n ranks, for poses in 3D.
void on_ranks(int n, void (*fact)(duet_cluster *c));

// The same of one that has none of the crowd's objects yet.
typedef void crowd_fact(duet_cluster *cluster, const crowd *c, rng *r);
void on_crowd(int n, uint64_t seed, double weight, crowd_fact *fact);

#endif
