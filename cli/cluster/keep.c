// SPDX-License-Identifier: MIT
#include "cli/cluster/keep.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/commands/profiles.h"
#include "profiles/cluster_run.h"
#include "profiles/key.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int lengths[] = {8, 64, 512, 4096, 32768, 262144, 2097152};

enum { N_LENGTHS = sizeof lengths / sizeof lengths[0] };

// Which machine each rank is on; all ranks have the same list.
typedef struct machines {
    char (*of)[PROFILE_SHA]; // [n_ranks] ids of machines
    int far;                 // the first rank on another machine than rank 0, else 1; 0: one rank
    uint32_t n;              // machines
} machines;

static bool find_machines(machines *m, ranks *r, duet_error *err)
{
    char own[PROFILE_SHA];
    profile_host(own);
    m->of = calloc((size_t)r->n, sizeof *m->of);
    if (!ranks_agree(r, m->of || error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n),
                     err))
        return false;
    ranks_gather(r, own, m->of, (int)sizeof own);
    m->far = r->n > 1;
    for (int i = r->n - 1; i >= 0; --i) {
        bool is_first = true;
        for (int k = 0; is_first && k < i; ++k)
            is_first = strcmp(m->of[k], m->of[i]) != 0;
        m->n += is_first;
        if (strcmp(m->of[0], m->of[i]) != 0)
            m->far = i;
    }
    return true;
}

// Writes times as {"64": 812.5, ...}, ns by bytes, and latency and time a byte into the fabric.
static bool measure(profile_fabric *fabric, text *times, ranks *r, int to, duet_error *err)
{
    void *bytes = calloc(1, (size_t)lengths[N_LENGTHS - 1]);
    if (!ranks_agree(r, bytes || error_set(err, DUET_STATUS_NO_MEMORY, "a message: no memory"),
                     err)) {
        free(bytes);
        return false;
    }
    for (int i = 0; i < N_LENGTHS; ++i) {
        double ns = ranks_ping_ns(r, to, bytes, lengths[i]);
        fabric->latency_ns = i == 0 ? ns : fabric->latency_ns;
        fabric->byte_ns = ns / lengths[i];
        text_add(times, "%s\"%d\": %.1f", i == 0 ? "{" : ", ", lengths[i], ns);
    }
    text_add(times, "}");
    fabric->times = text_chars(times);
    free(bytes);
    return true;
}

static bool write_run(const profile_fabric *fabric, const profile_cluster_run *run,
                      const duet_cluster_rank *rows, duet_error *err)
{
    char uid[PROFILE_ID];
    profile_cluster_rank *own = calloc(fabric->ranks, sizeof *own);
    for (uint32_t i = 0; own && i < fabric->ranks; ++i)
        own[i] = (profile_cluster_rank){.devices = rows[i].pair,
                                        .n = rows[i].objects,
                                        .ghosts = rows[i].ghosts,
                                        .pairs = rows[i].pairs,
                                        .sent_bytes = rows[i].sent_bytes,
                                        .busy_ns = rows[i].busy_ms * 1e6,
                                        .wait_ns = rows[i].wait_ms * 1e6};
    store *s = own ? profiles_open(NULL, STORE_WRITE, err) : NULL;
    bool ok = own || error_set(err, DUET_STATUS_NO_MEMORY, "%u ranks: no memory", fabric->ranks);
    ok = ok && s && cluster_run_put(s, fabric, run, own, uid, err);
    if (ok)
        fprintf(stderr, "duet: kept as %.8s in %s\n", uid, store_path(s));
    store_close(s);
    free(own);
    return ok;
}

bool keep_run(ranks *r, const profile_cluster_run *run, const duet_cluster_rank *rows,
              duet_error *err)
{
    machines m = {0};
    text times = {0};
    char mpi[MPI_MAX_LIBRARY_VERSION_STRING], place[PROFILE_SHA];
    if (!find_machines(&m, r, err)) {
        free(m.of);
        return false;
    }
    ranks_library(mpi);
    profile_sha((const char *)m.of, (size_t)r->n * sizeof *m.of, place);
    profile_fabric fabric = {.mpi = mpi, .place = place, .hosts = m.n, .ranks = (uint32_t)r->n};
    bool ok = m.far == 0 || measure(&fabric, &times, r, m.far, err);
    ok = ok && (r->self > 0 || (text_ok(&times, err) && write_run(&fabric, run, rows, err)));
    ok = ranks_agree(r, ok, err);
    text_free(&times);
    free(m.of);
    return ok;
}
