// SPDX-License-Identifier: MIT
// The ranks of an MPI job, and all that they say to each other: no other file calls MPI.
//
// A failure of one rank ends a phase on all of them. So every phase that can fail ends with
// ranks_agree, and no rank talks to others between a failure and that.
#ifndef CLUSTER_RANKS_H
#define CLUSTER_RANKS_H

#include "duet_error.h"

#include <mpi.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct ranks {
    MPI_Comm comm; // a copy of the caller's
    MPI_Comm host; // the ranks of this host
    int self;
    int n;
    int self_on_host; // from 0
    int n_on_host;
    bool goes_first; // on this host, where the others wait
    bool began_mpi;
    uint64_t wait_ns; // spent in the calls below
    uint64_t sent_bytes;
    char host_name[64];
} ranks;

// comm NULL: all ranks of the job. False with BAD_ARGUMENT where MPI cannot be begun any more.
bool ranks_begin(ranks *r, const MPI_Comm *comm, duet_error *err);
void ranks_end(ranks *r); // nothing where it did not begin

// Whether all ranks are well. Where not, every rank's err, unless NULL, becomes that of the
// least rank that failed: "rank 2 on HOST: LINE".
bool ranks_agree(ranks *r, bool ok, duet_error *err);

// ranks_agree at the beginning of a call, which fails on every rank, each with a line of its own,
// where the ranks make different ones.
bool ranks_agree_on(ranks *r, const char *call, bool ok, duet_error *err);

void ranks_wait(ranks *r); // until all are here
void ranks_sum(ranks *r, uint64_t *values, int n);
void ranks_least(ranks *r, uint64_t *values, int n);
void ranks_greatest(ranks *r, double *values, int n);
uint64_t ranks_sum_before(ranks *r, uint64_t value); // over the ranks below this one
// all is [n of ranks][bytes].
void ranks_gather(ranks *r, const void *own, void *all, int bytes);
void ranks_tell(ranks *r, void *of_rank_0, uint64_t bytes);

// The first rank of each host for which `has_work` holds goes first; the others wait for it.
// Between the two calls nothing is said to other ranks.
void ranks_await_turn(ranks *r, bool has_work);
void ranks_end_turn(ranks *r);

// Rows of one size for each rank: those for rank 0 come first, counts[q] for rank q.
typedef struct parcels {
    void *rows;
    uint64_t *counts; // [n of ranks]
    uint64_t n;       // of all rows
    uint32_t row_bytes;
} parcels;

bool parcels_begin(parcels *p, const ranks *r, uint32_t row_bytes, duet_error *err);
void parcels_end(parcels *p);
// Space for the rows that counts says; places[q], unless NULL, becomes the first of rank q's.
bool parcels_reserve(parcels *p, const ranks *r, uint64_t *places, duet_error *err);

// Sends each rank its rows; what others sent to this one becomes *in, from rank 0 on. Collective,
// and ends in agreement; `ok` is whether this rank has filled `out`.
bool ranks_exchange(ranks *r, bool ok, const parcels *out, parcels *in, duet_error *err);

#endif
