// SPDX-License-Identifier: MIT
#include "cluster/parcels.h"

#include "base/error.h"

#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { TAG_ROWS = 1, TAG_BALLAST };

bool parcels_begin(parcels *p, const ranks *r, uint32_t row_bytes, duet_error *err)
{
    if (!p->counts)
        p->counts = malloc((size_t)r->n * sizeof *p->counts);
    if (p->counts)
        memset(p->counts, 0, (size_t)r->n * sizeof *p->counts);
    p->n = 0;
    p->row_bytes = row_bytes;
    return p->counts || no_memory(err, "counts for %d ranks", r->n);
}

void parcels_end(parcels *p)
{
    free(p->rows);
    free(p->counts);
    *p = (parcels){0};
}

bool parcels_reserve(parcels *p, const ranks *r, uint64_t *places, duet_error *err)
{
    uint64_t n = 0;
    for (int q = 0; q < r->n; ++q) {
        if (p->counts[q] > INT_MAX)
            return error_set(err, DUET_STATUS_TOO_MANY,
                             "%" PRIu64 " rows between two ranks; %d are the most: more ranks have "
                             "fewer each",
                             p->counts[q], INT_MAX);
        if (places)
            places[q] = n;
        n += p->counts[q];
    }
    uint64_t bytes = (n > 0 ? n : 1) * p->row_bytes;
    if (!p->rows || bytes > p->bytes) {
        free(p->rows);
        p->rows = malloc(bytes + bytes / 8);
        p->bytes = p->rows ? bytes + bytes / 8 : 0;
    }
    p->n = p->rows ? n : 0;
    return p->rows || no_memory(err, "%" PRIu64 " rows of %u bytes", n, p->row_bytes);
}

// Bytes of the objects that a rank's rows stand for and that are not there.
static int ballast_bytes(const ranks *r, const parcels *p, int rank)
{
    uint64_t bytes = p->counts[rank] * p->row_bytes * (r->stands_for - 1);
    return rank == r->self ? 0 : bytes < INT_MAX ? (int)bytes : INT_MAX;
}

// Simulated messages are as long as if all objects were there.
static int post_ballast(ranks *r, const parcels *out, const parcels *in, MPI_Request *requests)
{
    int n = 0;
    for (int q = 0; r->stands_for > 1 && q < r->n; ++q) {
        void *bytes = r->simulation->ballast;
        int received = ballast_bytes(r, in, q), sent = ballast_bytes(r, out, q);
        if (received > 0)
            MPI_Irecv(bytes, received, MPI_BYTE, q, TAG_BALLAST, r->comm, &requests[n++]);
        if (sent > 0)
            MPI_Isend(bytes, sent, MPI_BYTE, q, TAG_BALLAST, r->comm, &requests[n++]);
    }
    return n;
}

// A message to and from each rank that has rows, this one included. Returns how many requests wait.
static int send_and_receive(ranks *r, const parcels *out, parcels *in, MPI_Request *requests)
{
    MPI_Datatype row;
    MPI_Type_contiguous((int)out->row_bytes, MPI_BYTE, &row);
    MPI_Type_commit(&row);
    int n = 0;
    unsigned char *to = in->rows;
    for (int q = 0; q < r->n; to += in->counts[q++] * in->row_bytes)
        if (in->counts[q] > 0)
            MPI_Irecv(to, (int)in->counts[q], row, q, TAG_ROWS, r->comm, &requests[n++]);
    const unsigned char *from = out->rows;
    for (int q = 0; q < r->n; from += out->counts[q++] * out->row_bytes) {
        if (out->counts[q] == 0)
            continue;
        MPI_Isend(from, (int)out->counts[q], row, q, TAG_ROWS, r->comm, &requests[n++]);
        r->sent_bytes += q == r->self ? 0 : out->counts[q] * out->row_bytes * r->stands_for;
    }
    n += post_ballast(r, out, in, requests + n);
    MPI_Type_free(&row); // once nothing under way needs it
    return n;
}

int parcels_begin_pass(ranks *r, const parcels *out, parcels *in, MPI_Request *requests)
{
    const rank_wait wait = ranks_begin_wait();
    int n = send_and_receive(r, out, in, requests);
    ranks_end_wait(r, wait);
    --r->n_waits; // it only begins
    return n;
}

void parcels_end_pass(ranks *r, int n, MPI_Request *requests)
{
    const rank_wait wait = ranks_begin_wait();
    MPI_Waitall(n, requests, MPI_STATUSES_IGNORE);
    ranks_end_wait(r, wait);
}

// A rank that cannot send, or not receive, says so in its counts.
static bool exchange_counts(ranks *r, bool ok, const parcels *out, parcels *in, duet_error *err)
{
    int failing = r->n;
    uint64_t *received = r->counts + r->n;
    for (int q = 0; q < r->n; ++q)
        r->counts[q] = ok ? out->counts[q] : UINT64_MAX;
    const rank_wait wait = ranks_begin_wait();
    MPI_Alltoall(r->counts, 1, MPI_UINT64_T, received, 1, MPI_UINT64_T, r->comm);
    ranks_end_wait(r, wait);
    for (int q = r->n - 1; q >= 0; --q)
        failing = received[q] == UINT64_MAX ? q : failing;
    if (failing < r->n)
        return ranks_fail(r, failing, err);
    memcpy(in->counts, received, (size_t)r->n * sizeof *r->counts);
    return true;
}

bool parcels_exchange(ranks *r, bool ok, const parcels *out, parcels *in, duet_error *err)
{
    MPI_Request *requests = malloc(4 * (size_t)r->n * sizeof(MPI_Request));
    if (ok && !requests)
        ok = no_memory(err, "messages to %d ranks", r->n);
    ok = ok && parcels_begin(in, r, out->row_bytes, err);
    ok = exchange_counts(r, ok, out, in, err) &&
         ranks_agree(r, parcels_reserve(in, r, NULL, err), err);
    if (ok)
        parcels_end_pass(r, parcels_begin_pass(r, out, in, requests), requests);
    else
        parcels_end(in);
    free(requests);
    return ok;
}

// Rows that lie in the order of ranks already go as they lie.
static bool lie_in_order(const ranks *r, const parcels_def *def)
{
    int last = 0;
    if (!def->rows || def->n > INT_MAX || r->stands_for > 1)
        return false;
    for (uint64_t i = 0; def->rank_of && i < def->n; ++i) {
        const int rank = def->rank_of(def->context, i);
        if (rank < last)
            return false;
        last = rank;
    }
    return true;
}

static void count(parcels *out, const parcels_def *def)
{
    for (uint64_t i = 0; i < def->n; ++i)
        ++out->counts[def->rank_of ? def->rank_of(def->context, i) : 0];
}

static bool fill(parcels *out, const ranks *r, const parcels_def *def, duet_error *err)
{
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    bool ok = places || no_memory(err, "%d ranks", r->n);
    if (ok)
        count(out, def);
    ok = ok && parcels_reserve(out, r, places, err);
    for (uint64_t i = 0; ok && i < def->n; ++i) {
        uint64_t to = places[def->rank_of ? def->rank_of(def->context, i) : 0]++;
        unsigned char *row = (unsigned char *)out->rows + to * out->row_bytes;
        if (def->rows)
            memcpy(row, (const unsigned char *)def->rows + i * def->row_bytes, def->row_bytes);
        else
            def->write(def->context, i, row);
    }
    free(places);
    return ok;
}

bool parcels_deal(ranks *r, bool ok, const parcels_def *def, parcels *in, duet_error *err)
{
    parcels out = {0};
    const bool lent = ok && lie_in_order(r, def);
    ok = parcels_begin(&out, r, (uint32_t)def->row_bytes, err) && ok;
    if (ok && lent) {
        count(&out, def);
        out.rows = (void *)def->rows;
        out.n = def->n;
    }
    ok = ok && (lent || fill(&out, r, def, err));
    ok = parcels_exchange(r, ok, &out, in, err);
    if (lent)
        out.rows = NULL;
    parcels_end(&out);
    return ok;
}
