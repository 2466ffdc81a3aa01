// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // getifaddrs
#include "cluster/beacon.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

// Each rank tells it to all others at the beginning.
typedef struct introduction {
    beacon_rank self;
    bool leads;    // the first on its host
    bool is_alone; // and the only one
    int n_addresses;
    in_addr_t addresses[BEACON_ADDRESSES];
    in_port_t port;
    uint64_t token; // rank 0's counts
} introduction;

typedef struct datagram {
    uint64_t token;
    uint64_t beats;
    int rank;
} datagram;

// ---------------------------------------------------------------- begin and end

static int list_addresses(in_addr_t addresses[BEACON_ADDRESSES])
{
    struct ifaddrs *all = NULL;
    int n = 0;
    if (getifaddrs(&all) != 0)
        return 0;
    for (const struct ifaddrs *a = all; a && n < BEACON_ADDRESSES; a = a->ifa_next)
        if (a->ifa_addr && a->ifa_addr->sa_family == AF_INET && (a->ifa_flags & IFF_UP) &&
            !(a->ifa_flags & IFF_LOOPBACK))
            addresses[n++] =
                ((const struct sockaddr_in *)(const void *)a->ifa_addr)->sin_addr.s_addr;
    freeifaddrs(all);
    return n;
}

// Opens a socket with a port of its own.
static int open_socket(in_port_t *port)
{
    struct sockaddr_in any = {.sin_family = AF_INET};
    socklen_t size = sizeof any;
    int s = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (s < 0)
        return -1;
    if (bind(s, (struct sockaddr *)&any, size) != 0 ||
        getsockname(s, (struct sockaddr *)&any, &size) != 0) {
        close(s);
        return -1;
    }
    *port = any.sin_port;
    return s;
}

static introduction introduce(beacon *b, const ranks *r)
{
    introduction own = {.self = {.rank = r->self, .pid = (int)getpid()},
                        .leads = r->self_on_host == 0,
                        .is_alone = r->n_on_host == 1};
    snprintf(own.self.host_name, sizeof own.self.host_name, "%.63s", r->host_name);
    if (own.leads)
        b->socket = open_socket(&own.port);
    if (b->socket >= 0)
        own.n_addresses = list_addresses(own.addresses);
    if (getrandom(&own.token, sizeof own.token, GRND_NONBLOCK) != sizeof own.token)
        own.token = (uint64_t)getpid();
    return own;
}

// The rank that watches rank 0; 0: there is one host.
static int watcher_of_rank_0(const introduction *all, int n)
{
    int i = 1;
    while (i < n && !all[i].leads)
        ++i;
    return i < n ? i : 0;
}

static void find_watcher(beacon *b, const introduction *watcher)
{
    for (b->n_addresses = 0; b->n_addresses < watcher->n_addresses; ++b->n_addresses)
        b->watcher[b->n_addresses] =
            (struct sockaddr_in){.sin_family = AF_INET,
                                 .sin_port = watcher->port,
                                 .sin_addr.s_addr = watcher->addresses[b->n_addresses]};
}

static void find_ranks(beacon *b, const introduction *all, const ranks *r)
{
    int second = watcher_of_rank_0(all, r->n);
    b->heard = calloc((size_t)r->n, sizeof *b->heard);
    for (int i = 0; second > 0 && i < r->n; ++i) {
        int watcher = i == 0 ? second : 0;
        if (all[i].is_alone && i == r->self)
            find_watcher(b, &all[watcher]);
        if (all[i].is_alone && watcher == r->self && b->heard)
            b->heard[b->n_heard++] = all[i].self;
    }
}

void beacon_begin(beacon *b, ranks *r)
{
    *b = (beacon){.socket = -1, .rank = r->self};
    introduction own = introduce(b, r);
    introduction *all = calloc((size_t)r->n, sizeof *all);
    uint64_t lacking = all ? 0 : 1;
    ranks_sum(r, &lacking, 1);
    if (lacking == 0) {
        ranks_gather(r, &own, all, (int)sizeof own);
        b->token = all[0].token;
        find_ranks(b, all, r);
    }
    free(all);
}

void beacon_end(beacon *b)
{
    if (b->socket >= 0)
        close(b->socket);
    free(b->heard);
    *b = (beacon){.socket = -1};
}

// ---------------------------------------------------------------- beats

void beacon_send(beacon *b)
{
    datagram d = {.token = b->token, .beats = ++b->sent, .rank = b->rank};
    for (int i = 0; i < b->n_addresses; ++i)
        (void)sendto(b->socket, &d, sizeof d, MSG_DONTWAIT | MSG_NOSIGNAL,
                     (const struct sockaddr *)&b->watcher[i], sizeof b->watcher[i]);
}

void beacon_hear(beacon *b)
{
    datagram d;
    while (b->socket >= 0 && recv(b->socket, &d, sizeof d, MSG_DONTWAIT) == sizeof d)
        for (int i = 0; i < b->n_heard; ++i)
            if (d.token == b->token && d.rank == b->heard[i].rank)
                b->heard[i].beats = d.beats;
}
