// SPDX-License-Identifier: MIT
// The ranks of an MPI job, and all that they say to each other: no file but this one and parcels.c
// calls MPI.
//
// A failure of one rank ends a phase on all of them. So every phase that can fail ends with
// ranks_agree, and no rank talks to others between a failure and that.
#ifndef CLUSTER_RANKS_H
#define CLUSTER_RANKS_H

#include "duet_error.h"

#include <mpi.h>
#include <stdbool.h>
#include <stdint.h>

// Replaces devices and time if the ranks are simulated.
typedef struct simulation {
    uint32_t stands_for;   // objects of a larger scene, for each object
    double object_seconds; // a rank's step takes for each object or ghost; 0: it finds pairs
    const struct ghost_traffic *traffic; // that ranks begin with; NULL: nothing moves
    void (*pass)(double seconds);        // lets simulated time pass for this rank
    void *ballast;                       // memory of any message's size, which nobody reads
} simulation;

typedef struct ranks {
    MPI_Comm comm; // a copy of the caller's
    MPI_Comm host; // the ranks of this host
    MPI_Op merge;  // merges what they agree on
    MPI_Datatype agreement;
    int self;
    int n;
    int self_on_host; // from 0
    int n_on_host;
    double processors; // the host's processors for this rank: the processors that it may use, each
                       // divided among the ranks of the host that may use it, too
    const simulation *simulation;        // NULL: they are real
    const struct ghost_traffic *traffic; // simulated bodies that move have it; else NULL
    uint32_t stands_for; // objects of a larger scene, for each object; 1 if they are real
    bool goes_first;     // on this host, where the others wait
    bool began_mpi;
    uint64_t *counts; // [2][n] sent to each rank, and received from each
    uint64_t wait_ns; // spent in the calls below
    uint64_t n_waits; // so many of them
    uint64_t spun_ns; // of this process's processor time, likewise
    uint64_t sent_bytes;
    char host_name[MPI_MAX_PROCESSOR_NAME];
} ranks;

// comm NULL: all ranks of the job. False with BAD_ARGUMENT if MPI cannot be begun any more.
bool ranks_begin(ranks *r, const MPI_Comm *comm, const simulation *s, duet_error *err);
// Memory that all of it needs; not collective.
bool ranks_reserve(ranks *r, duet_error *err);
void ranks_end(ranks *r); // nothing if it did not begin

// Zeroed memory that all ranks of this host have; NULL on all of them if there is none. Collective,
// as is giving it back.
void *ranks_share(ranks *r, size_t bytes, MPI_Win *window);
void ranks_unshare(MPI_Win *window);

// How long the job has run, for this rank. Tests put a clock of their own in its place.
extern uint64_t (*ranks_now_ns)(void);

// For parcels.c: the times around a call in which this rank may have to wait.
typedef struct rank_wait {
    uint64_t begun_ns, spun_ns;
} rank_wait;

rank_wait ranks_begin_wait(void);
void ranks_end_wait(ranks *r, rank_wait wait);

// Every rank's err, unless NULL, becomes the err of the failing rank. Returns false.
bool ranks_fail(ranks *r, int failing, duet_error *err);

// Returns whether all ranks are well. If not, every rank's err, unless NULL, becomes the err of the
// least rank that failed: "rank 2 on HOST: LINE".
bool ranks_agree(ranks *r, bool ok, duet_error *err);

// Whether this rank has not failed in the call whose failures go there. Only the next agreement
// tells others.
static inline bool is_well(const duet_error *own)
{
    return own->status == DUET_STATUS_OK;
}

// Numbers that ranks add to whether they are well: sums over all, and the greatest of all. One
// message is as quick as another, so a phase has few of them.
typedef struct tally {
    uint64_t sums[6];
    double greatest[2];
} tally;

// Does as ranks_agree, and makes t, unless NULL, the tally of all ranks.
bool ranks_agree_and(ranks *r, bool ok, tally *t, duet_error *err);

// The same at the beginning of a call, which fails on every rank, each with a line of its own, if
// the ranks make different calls.
bool ranks_agree_on(ranks *r, const char *call, bool ok, tally *t, duet_error *err);

// Waits until all ranks are here; ranks that make another call meanwhile are refused it. Does
// nothing if ranks did not begin.
void ranks_await_end(ranks *r, const char *call);

void ranks_wait(ranks *r); // until all are here
void ranks_sum(ranks *r, uint64_t *values, int n);
void ranks_least(ranks *r, uint64_t *values, int n);
double ranks_greatest(ranks *r, double value);
uint64_t ranks_sum_before(ranks *r, uint64_t value); // over the ranks below this one
// all is [n of ranks][bytes].
void ranks_gather(ranks *r, const void *own, void *all, int bytes);
void ranks_broadcast(ranks *r, void *of_rank_0, uint64_t bytes);
// Returns rank 0's text on every rank, to be freed; NULL: "". On all ranks NULL without memory.
char *ranks_broadcast_text(ranks *r, const char *of_rank_0, duet_error *err);

// The first rank of each host for which `has_work` holds goes first; the others wait for it.
// Between the two calls nothing is said to other ranks.
void ranks_await_turn(ranks *r, bool has_work);
void ranks_end_turn(ranks *r);

#endif
