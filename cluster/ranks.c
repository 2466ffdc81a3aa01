// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cluster/ranks.h"

#include "base/clock.h"
#include "base/error.h"

#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TAG_ROWS = 1 };

// A statement in which this rank may have to wait.
#define WAITING(r, statement)                          \
    do {                                               \
        uint64_t begun_ns_ = clock_steady_ns();        \
        statement;                                     \
        (r)->wait_ns += clock_steady_ns() - begun_ns_; \
    } while (0)

// ---------------------------------------------------------------- begin and end

static bool begin_mpi(ranks *r, duet_error *err)
{
    int begun = 0, ended = 0, level = 0;
    MPI_Initialized(&begun);
    MPI_Finalized(&ended);
    if (ended)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a cluster: MPI has ended in this process; expected MPI_Init before the "
                         "first of several clusters");
    if (!begun)
        MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    r->began_mpi = !begun;
    return true;
}

bool ranks_begin(ranks *r, const MPI_Comm *comm, duet_error *err)
{
    *r = (ranks){.comm = MPI_COMM_NULL, .host = MPI_COMM_NULL};
    if (!begin_mpi(r, err))
        return false;
    MPI_Comm_dup(comm ? *comm : MPI_COMM_WORLD, &r->comm);
    MPI_Comm_rank(r->comm, &r->self);
    MPI_Comm_size(r->comm, &r->n);
    MPI_Comm_split_type(r->comm, MPI_COMM_TYPE_SHARED, r->self, MPI_INFO_NULL, &r->host);
    MPI_Comm_rank(r->host, &r->self_on_host);
    MPI_Comm_size(r->host, &r->n_on_host);
    if (gethostname(r->host_name, sizeof r->host_name - 1) != 0)
        strcpy(r->host_name, "?");
    return true;
}

void ranks_end(ranks *r)
{
    if (r->host != MPI_COMM_NULL)
        MPI_Comm_free(&r->host);
    if (r->comm != MPI_COMM_NULL)
        MPI_Comm_free(&r->comm);
    if (r->began_mpi)
        MPI_Finalize();
    r->began_mpi = false;
}

// ---------------------------------------------------------------- all at once

// Every rank's err becomes that of the least rank that failed.
static bool tell_failure(ranks *r, int failing, duet_error *err)
{
    duet_error first = {0};
    if (failing == r->self && err)
        first = *err;
    if (failing == r->self && first.status == DUET_STATUS_OK)
        error_set(&first, DUET_STATUS_NO_MEMORY, "it failed without a line");
    if (failing == r->self && r->n > 1) {
        duet_error own = first;
        first = (duet_error){.cl_code = own.cl_code};
        error_set(&first, own.status, "rank %d on %s: %s", r->self, r->host_name, own.text);
    }
    WAITING(r, MPI_Bcast(&first, (int)sizeof first, MPI_BYTE, failing, r->comm));
    if (err)
        *err = first;
    return false;
}

bool ranks_agree(ranks *r, bool ok, duet_error *err)
{
    return ranks_agree_on(r, "", ok, err);
}

// The names of two calls differ in their sums of squares.
static int number_of(const char *call)
{
    int number = 0;
    for (; *call; ++call)
        number += *call * *call;
    return number;
}

bool ranks_agree_on(ranks *r, const char *call, bool ok, duet_error *err)
{
    int least[] = {ok ? r->n : r->self, number_of(call), -number_of(call)};
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, least, 3, MPI_INT, MPI_MIN, r->comm));
    if (least[1] != -least[2])
        return error_set(
            err, DUET_STATUS_BAD_ARGUMENT,
            "rank %d on %s: %s, and another rank makes another call; expected the same "
            "calls in the same order on all ranks",
            r->self, r->host_name, *call ? call : "in the middle of one");
    return least[0] == r->n || tell_failure(r, least[0], err);
}

void ranks_wait(ranks *r)
{
    WAITING(r, MPI_Barrier(r->comm));
}

void ranks_sum(ranks *r, uint64_t *values, int n)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_UINT64_T, MPI_SUM, r->comm));
}

void ranks_least(ranks *r, uint64_t *values, int n)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_UINT64_T, MPI_MIN, r->comm));
}

void ranks_greatest(ranks *r, double *values, int n)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_DOUBLE, MPI_MAX, r->comm));
}

uint64_t ranks_sum_before(ranks *r, uint64_t value)
{
    uint64_t before = 0;
    WAITING(r, MPI_Exscan(&value, &before, 1, MPI_UINT64_T, MPI_SUM, r->comm));
    return r->self == 0 ? 0 : before; // which MPI leaves open
}

void ranks_gather(ranks *r, const void *own, void *all, int bytes)
{
    WAITING(r, MPI_Allgather(own, bytes, MPI_BYTE, all, bytes, MPI_BYTE, r->comm));
}

void ranks_tell(ranks *r, void *of_rank_0, uint64_t bytes)
{
    unsigned char *at = of_rank_0;
    while (bytes > 0) {
        int now = bytes < INT_MAX ? (int)bytes : INT_MAX;
        WAITING(r, MPI_Bcast(at, now, MPI_BYTE, 0, r->comm));
        at += now;
        bytes -= (uint64_t)now;
    }
}

// ---------------------------------------------------------------- one before the others

void ranks_await_turn(ranks *r, bool has_work)
{
    int first = has_work ? r->self_on_host : r->n_on_host;
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, r->host));
    if (first != r->self_on_host)
        WAITING(r, MPI_Barrier(r->host));
    r->goes_first = first == r->self_on_host;
}

void ranks_end_turn(ranks *r)
{
    if (r->goes_first)
        WAITING(r, MPI_Barrier(r->host));
    r->goes_first = false;
}

// ---------------------------------------------------------------- rows

bool parcels_begin(parcels *p, const ranks *r, uint32_t row_bytes, duet_error *err)
{
    *p = (parcels){.counts = calloc((size_t)r->n, sizeof *p->counts), .row_bytes = row_bytes};
    return p->counts ||
           error_set(err, DUET_STATUS_NO_MEMORY, "counts for %d ranks: no memory", r->n);
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
    free(p->rows);
    p->n = n;
    p->rows = malloc((n > 0 ? n : 1) * p->row_bytes);
    return p->rows || error_set(err, DUET_STATUS_NO_MEMORY,
                                "%" PRIu64 " rows of %u bytes: no memory", n, p->row_bytes);
}

// A message to and from each rank that has rows, this one included.
static void send_and_receive(ranks *r, const parcels *out, parcels *in, MPI_Request *requests)
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
        r->sent_bytes += q == r->self ? 0 : out->counts[q] * out->row_bytes;
    }
    MPI_Waitall(n, requests, MPI_STATUSES_IGNORE);
    MPI_Type_free(&row);
}

bool ranks_exchange(ranks *r, bool ok, const parcels *out, parcels *in, duet_error *err)
{
    MPI_Request *requests = malloc(2 * (size_t)r->n * sizeof(MPI_Request));
    *in = (parcels){0};
    if (ok && !requests)
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "messages to %d ranks: no memory", r->n);
    ok = ranks_agree(r, ok && parcels_begin(in, r, out->row_bytes, err), err);
    if (ok) {
        WAITING(r,
                MPI_Alltoall(out->counts, 1, MPI_UINT64_T, in->counts, 1, MPI_UINT64_T, r->comm));
        ok = ranks_agree(r, parcels_reserve(in, r, NULL, err), err);
    }
    if (ok)
        WAITING(r, send_and_receive(r, out, in, requests));
    else
        parcels_end(in);
    free(requests);
    return ok;
}
