// SPDX-License-Identifier: MIT
// Beats of ranks that are alone on their hosts, whose memory no other rank has: each sends a
// datagram (UDP, IPv4) a beat to the one rank that watches it. That is rank 0, and for rank 0 the
// first rank of another host. Beats that no network lets through show nobody as silent: only a rank
// that was heard can fall silent.
#ifndef CLUSTER_BEACON_H
#define CLUSTER_BEACON_H

#include "cluster/ranks.h"

#include <netinet/in.h>

enum { BEACON_ADDRESSES = 8 };

// A rank that is alone on its host.
typedef struct beacon_rank {
    int rank;
    int pid;
    char host_name[64];
    uint64_t beats; // 0: not heard yet
} beacon_rank;

typedef struct beacon {
    int socket;     // -1: neither sends nor hears
    int rank;       // this one
    uint64_t token; // of this job
    uint64_t sent;
    struct sockaddr_in watcher[BEACON_ADDRESSES]; // addresses of the rank that watches this one
    int n_addresses;
    beacon_rank *heard; // [n_heard], that this rank watches
    int n_heard;
} beacon;

// Collective. Without memory, or a socket, this rank neither sends nor hears.
void beacon_begin(beacon *b, ranks *r);
void beacon_send(beacon *b);
void beacon_hear(beacon *b); // all beats that came
void beacon_end(beacon *b);

#endif
