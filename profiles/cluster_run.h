// SPDX-License-Identifier: MIT
// What runs of duet cluster showed: the network between their ranks, and what each rank did.
#ifndef PROFILES_CLUSTER_RUN_H
#define PROFILES_CLUSTER_RUN_H

#include "profiles/subject.h"

typedef struct profile_cluster_run {
    const char *scene;
    uint32_t dims;
    uint64_t n;
    const char *level;
    uint32_t parts; // that each rank's objects were searched in
    bool resident;
    uint64_t steps;   // that the times are of
    double median_ns; // and the quickest and the slowest of them
    double low_ns;
    double high_ns;
} profile_cluster_run;

// A rank's work in the last step.
typedef struct profile_cluster_rank {
    const char *devices; // "A,B", or one
    uint64_t n;
    uint64_t ghosts;
    uint64_t pairs;
    uint64_t sent_bytes;
    double busy_ns;
    double wait_ns;
} profile_cluster_rank;

// Keeps a run, ranks[fabric->ranks] with it, and what was measured of the fabric in the place of
// what is known of that. uid becomes the run's.
bool cluster_run_put(store *s, const profile_fabric *fabric, const profile_cluster_run *run,
                     const profile_cluster_rank *ranks, char uid[PROFILE_ID], duet_error *err);

// A run as people see it; texts until the next.
typedef struct cluster_run_entry {
    int64_t id;
    const char *uid;
    int64_t created_ns;
    profile_cluster_run run;
    profile_fabric fabric;
    int64_t measured_ns; // the fabric
    double efficiency;   // the part of the last step's time, of all ranks, in which they were busy
} cluster_run_entry;

typedef bool cluster_run_visit(void *context, const cluster_run_entry *entry);
typedef bool cluster_rank_visit(void *context, uint32_t rank, const profile_cluster_rank *row);

// Visits the runs whose uid begins so, NULL for all, by time; ends early if a visit returns false.
bool cluster_run_each(store *s, const char *uid, cluster_run_visit *visit, void *context,
                      duet_error *err);
bool cluster_rank_each(store *s, int64_t run_id, cluster_rank_visit *visit, void *context,
                       duet_error *err);

// The whole uid of the one run that begins so; empty where there is none, or where a profile's
// begins so too. BAD_ARGUMENT for several.
bool cluster_run_find(store *s, const char *uid, char whole[PROFILE_ID], duet_error *err);
bool cluster_run_forget(store *s, const char *whole, duet_error *err);

#endif
