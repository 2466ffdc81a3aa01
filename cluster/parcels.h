// SPDX-License-Identifier: MIT
// Rows that ranks send each other.
#ifndef CLUSTER_PARCELS_H
#define CLUSTER_PARCELS_H

#include "cluster/ranks.h"

// Rows of one size for each rank: those for rank 0 come first, counts[q] for rank q.
typedef struct parcels {
    void *rows;
    uint64_t *counts; // [n of ranks]
    uint64_t n;       // the number of all rows
    uint32_t row_bytes;
    uint64_t bytes; // bytes for which rows has memory: the memory of the last time is used again
} parcels;

// No rows, whatever there was.
bool parcels_begin(parcels *p, const ranks *r, uint32_t row_bytes, duet_error *err);
void parcels_end(parcels *p);
// Space for the rows that counts says; places[q], unless NULL, becomes the first of rank q's.
bool parcels_reserve(parcels *p, const ranks *r, uint64_t *places, duet_error *err);

// Sends each rank its rows; what others sent to this one becomes *in, from rank 0 on. Collective,
// and ends in agreement; `ok` is whether this rank has filled `out`.
bool parcels_exchange(ranks *r, bool ok, const parcels *out, parcels *in, duet_error *err);

// Sends and receives rows of which both sides know how many there are, as the counts and the memory
// of both parcels say; it cannot fail. requests has space for 4 for each rank. Between the two
// calls rows travel and nobody touches them: begin returns how many requests end waits for.
int parcels_begin_pass(ranks *r, const parcels *out, parcels *in, MPI_Request *requests);
void parcels_end_pass(ranks *r, int n, MPI_Request *requests);

// Rows to send, and where each goes.
typedef struct parcels_def {
    uint64_t n;
    size_t row_bytes;
    const void *rows;                                          // [n] that travel as they are; NULL:
    void (*write)(const void *context, uint64_t i, void *row); // makes them
    int (*rank_of)(const void *context, uint64_t i);           // NULL: all go to rank 0
    const void *context;
} parcels_def;

// Sends the rows of the def; else as parcels_exchange.
bool parcels_deal(ranks *r, bool ok, const parcels_def *def, parcels *in, duet_error *err);

#endif
