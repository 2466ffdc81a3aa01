// SPDX-License-Identifier: MIT
// Tells of ranks on this host that no longer answer: processes that were stopped or get no time,
// for which the others would wait without a word.
//
// A thread of each rank counts in memory that the ranks of a host share, and of a rank that is
// alone on its host in datagrams. A rank that computes or waits counts on, and a stopped one does
// not. Steps are not touched.
#ifndef CLUSTER_RANK_WATCH_H
#define CLUSTER_RANK_WATCH_H

#include "cluster/beacon.h"
#include "cluster/ranks.h"

#include <pthread.h>

typedef struct rank_heartbeat rank_heartbeat;

typedef struct rank_watch {
    ranks all;
    MPI_Win window;
    rank_heartbeat *heartbeats; // [n_on_host], shared
    beacon beacon;              // of ranks that are alone on their hosts
    struct last_heard
        *last;      // [n_on_host], then of those that the beacon hears: what was heard of each
    double seconds; // seconds of silence, after which a rank is reported
    pthread_mutex_t lock;
    pthread_cond_t ended;
    bool ends;
    bool watches; // a thread runs
    pthread_t thread;
    void (*say)(const char *line); // from that thread
} rank_watch;

// Begins for all ranks of the job; collective. seconds 0: this rank neither watches nor is watched.
bool rank_watch_begin(rank_watch *w, double seconds, void (*say)(const char *line),
                      duet_error *err);
void rank_watch_end(rank_watch *w); // collective

#endif
