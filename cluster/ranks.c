// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // sched_getaffinity
#include "cluster/ranks.h"

#include "base/clock.h"
#include "base/error.h"

#include <limits.h>
#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { REST_NS = 500000 };

// ---------------------------------------------------------------- what they agree on

typedef struct agreement {
    int failing;     // the least rank that does; all of them: none
    int least, most; // numbers of the calls that they make
    tally tally;
} agreement;

static void merge(void *from, void *into, int *n, MPI_Datatype *type)
{
    const agreement *a = from;
    agreement *b = into;
    (void)type;
    for (int i = 0; i < *n; ++i, ++a, ++b) {
        b->failing = a->failing < b->failing ? a->failing : b->failing;
        b->least = a->least < b->least ? a->least : b->least;
        b->most = a->most > b->most ? a->most : b->most;
        for (int k = 0; k < 6; ++k)
            b->tally.sums[k] += a->tally.sums[k];
        for (int k = 0; k < 2; ++k)
            b->tally.greatest[k] = fmax(a->tally.greatest[k], b->tally.greatest[k]);
    }
}

// ---------------------------------------------------------------- begin and end

static bool begin_mpi(ranks *r, duet_error *err)
{
    int begun = 0, ended = 0, level = 0;
    MPI_Initialized(&begun);
    MPI_Finalized(&ended);
    if (ended)
        return bad_argument(err, "a cluster: MPI has ended in this process; expected MPI_Init "
                                 "before the first of several clusters");
    if (!begun)
        MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    r->began_mpi = !begun;
    return true;
}

// Simulated ranks are in one process.
static double own_processors(const ranks *r)
{
    static const int most = CPU_SETSIZE;
    cpu_set_t own;
    int uses[CPU_SETSIZE];
    double processors = 0;
    CPU_ZERO(&own);
    bool known = sched_getaffinity(0, sizeof own, &own) == 0;
    if (r->simulation)
        return (double)CPU_COUNT(&own) / r->n;
    for (int i = 0; i < most; ++i)
        uses[i] = CPU_ISSET(i, &own) != 0;
    MPI_Allreduce(MPI_IN_PLACE, uses, most, MPI_INT, MPI_SUM, r->host);
    for (int i = 0; known && i < most; ++i)
        processors += CPU_ISSET(i, &own) ? 1.0 / uses[i] : 0;
    return processors;
}

bool ranks_begin(ranks *r, const MPI_Comm *comm, const simulation *s, duet_error *err)
{
    int length = 0;
    *r = (ranks){.comm = MPI_COMM_NULL, .host = MPI_COMM_NULL, .simulation = s};
    r->stands_for = s ? s->stands_for : 1;
    r->traffic = s ? s->traffic : NULL;
    if (!begin_mpi(r, err))
        return false;
    MPI_Comm_dup(comm ? *comm : MPI_COMM_WORLD, &r->comm);
    MPI_Comm_rank(r->comm, &r->self);
    MPI_Comm_size(r->comm, &r->n);
    MPI_Comm_split_type(r->comm, MPI_COMM_TYPE_SHARED, r->self, MPI_INFO_NULL, &r->host);
    MPI_Comm_rank(r->host, &r->self_on_host);
    MPI_Comm_size(r->host, &r->n_on_host);
    MPI_Op_create(merge, true, &r->merge);
    MPI_Type_contiguous((int)sizeof(agreement), MPI_BYTE, &r->agreement);
    MPI_Type_commit(&r->agreement);
    MPI_Get_processor_name(r->host_name, &length);
    r->processors = own_processors(r);
    return true;
}

bool ranks_reserve(ranks *r, duet_error *err)
{
    r->counts = calloc(2 * (size_t)r->n, sizeof *r->counts);
    return r->counts || no_memory(err, "%d ranks", r->n);
}

void ranks_end(ranks *r)
{
    free(r->counts);
    r->counts = NULL;
    if (r->host != MPI_COMM_NULL) {
        MPI_Type_free(&r->agreement);
        MPI_Op_free(&r->merge);
        MPI_Comm_free(&r->host);
    }
    if (r->comm != MPI_COMM_NULL)
        MPI_Comm_free(&r->comm);
    if (r->began_mpi)
        MPI_Finalize();
    r->began_mpi = false;
}

void *ranks_share(ranks *r, size_t bytes, MPI_Win *window)
{
    void *memory = NULL;
    MPI_Aint size = r->self_on_host == 0 ? (MPI_Aint)bytes : 0;
    int unit = 1;
    MPI_Comm_set_errhandler(r->host, MPI_ERRORS_RETURN);
    int ok =
        MPI_Win_allocate_shared(size, unit, MPI_INFO_NULL, r->host, &memory, window) == MPI_SUCCESS;
    MPI_Comm_set_errhandler(r->host, MPI_ERRORS_ARE_FATAL);
    MPI_Allreduce(MPI_IN_PLACE, &ok, 1, MPI_INT, MPI_LAND, r->host);
    if (!ok)
        return NULL;
    MPI_Win_shared_query(*window, 0, &size, &unit, &memory);
    if (r->self_on_host == 0)
        memset(memory, 0, bytes);
    MPI_Barrier(r->host);
    return memory;
}

void ranks_unshare(MPI_Win *window)
{
    MPI_Win_free(window);
}

static uint64_t mpi_now_ns(void)
{
    return (uint64_t)(MPI_Wtime() * 1e9);
}

uint64_t (*ranks_now_ns)(void) = mpi_now_ns;

rank_wait ranks_begin_wait(void)
{
    return (rank_wait){ranks_now_ns(), clock_process_ns()};
}

void ranks_end_wait(ranks *r, rank_wait wait)
{
    ++r->n_waits;
    r->wait_ns += ranks_now_ns() - wait.begun_ns;
    r->spun_ns += clock_process_ns() - wait.spun_ns;
}

#define WAITING(r, statement)                   \
    do {                                        \
        const rank_wait w = ranks_begin_wait(); \
        statement;                              \
        ranks_end_wait(r, w);                   \
    } while (0)

// ---------------------------------------------------------------- all at once

bool ranks_fail(ranks *r, int failing, duet_error *err)
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
    if (err) {
        first.calls = err->calls;
        *err = first;
    }
    return false;
}

bool ranks_agree(ranks *r, bool ok, duet_error *err)
{
    return ranks_agree_and(r, ok, NULL, err);
}

bool ranks_agree_and(ranks *r, bool ok, tally *t, duet_error *err)
{
    return ranks_agree_on(r, "", ok, t, err);
}

// The names of two calls differ in their sums of squares.
static int number_of(const char *call)
{
    int number = 0;
    for (; *call; ++call)
        number += *call * *call;
    return number;
}

bool ranks_agree_on(ranks *r, const char *call, bool ok, tally *t, duet_error *err)
{
    agreement all = {.failing = ok ? r->n : r->self, .least = number_of(call)};
    all.most = all.least;
    if (t)
        all.tally = *t;
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, &all, 1, r->agreement, r->merge, r->comm));
    if (all.least != all.most)
        return bad_argument(err,
                            "rank %d on %s: %s, and another rank makes another call; expected the "
                            "same calls in the same order on all ranks",
                            r->self, r->host_name, *call ? call : "in the middle of one");
    if (t)
        *t = all.tally;
    return all.failing == r->n || ranks_fail(r, all.failing, err);
}

void ranks_await_end(ranks *r, const char *call)
{
    while (r->comm != MPI_COMM_NULL && !ranks_agree_on(r, call, true, NULL, NULL))
        continue;
}

void ranks_wait(ranks *r)
{
    WAITING(r, MPI_Barrier(r->comm));
}

// Until all are here, leaving the processors to others: a rank that waits in MPI itself keeps one
// busy.
static void rest(MPI_Comm comm)
{
    MPI_Request all_are_here;
    int here = 0;
    MPI_Ibarrier(comm, &all_are_here);
    while (MPI_Test(&all_are_here, &here, MPI_STATUS_IGNORE) == MPI_SUCCESS && !here)
        nanosleep(&(struct timespec){.tv_nsec = REST_NS}, NULL);
}

void ranks_sum(ranks *r, uint64_t *values, int n)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_UINT64_T, MPI_SUM, r->comm));
}

void ranks_least(ranks *r, uint64_t *values, int n)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, values, n, MPI_UINT64_T, MPI_MIN, r->comm));
}

double ranks_greatest(ranks *r, double value)
{
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, r->comm));
    return value;
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

void ranks_broadcast(ranks *r, void *of_rank_0, uint64_t bytes)
{
    unsigned char *at = of_rank_0;
    while (bytes > 0) {
        int now = bytes < INT_MAX ? (int)bytes : INT_MAX;
        WAITING(r, MPI_Bcast(at, now, MPI_BYTE, 0, r->comm));
        at += now;
        bytes -= (uint64_t)now;
    }
}

char *ranks_broadcast_text(ranks *r, const char *of_rank_0, duet_error *err)
{
    uint64_t bytes = of_rank_0 ? strlen(of_rank_0) + 1 : 1;
    ranks_broadcast(r, &bytes, sizeof bytes);
    char *text = calloc(bytes, 1);
    if (!ranks_agree(r, text || no_memory(err, "a text"), err)) {
        free(text);
        return NULL;
    }
    if (r->self == 0 && of_rank_0)
        memcpy(text, of_rank_0, bytes);
    ranks_broadcast(r, text, bytes);
    return text;
}

// ---------------------------------------------------------------- one before the others

void ranks_await_turn(ranks *r, bool has_work)
{
    int first = has_work ? r->self_on_host : r->n_on_host;
    WAITING(r, MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, r->host));
    if (first != r->self_on_host)
        WAITING(r, rest(r->host));
    r->goes_first = first == r->self_on_host;
}

void ranks_end_turn(ranks *r)
{
    if (r->goes_first)
        WAITING(r, rest(r->host));
    r->goes_first = false;
}
