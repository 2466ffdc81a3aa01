// SPDX-License-Identifier: MIT
#include "cli/cluster/stored_run.h"

#include "base/error.h"
#include "cli/commands/profiles.h"
#include "profiles/cluster_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// What a network and a rank can be at most: a store may have been written by anybody.
static const double MOST_LATENCY_NS = 1e10, MOST_BYTE_NS = 1e9, MOST_OBJECT_S = 1;

enum { MOST_RANKS = 1 << 24 };

typedef struct reading {
    store *s;
    stored_run *run;
    double *seen;     // [n_seconds] homes, and what ghosts take in homes
    double *busy_ns;  // [n_seconds]
    bool are_apart;   // so far: each has all objects, which share no homes
    double busiest;   // the greatest part of the last step that a rank was busy in
    double median_ns; // of all steps
    duet_error *err;
    bool ok;
} reading;

static bool is_from(double value, double least, double most)
{
    return value >= least && value <= most; // false of NaN
}

bool stored_time_can_be(double object_seconds)
{
    return object_seconds > 0 && object_seconds <= MOST_OBJECT_S;
}

static bool refuse(reading *r, const char *what)
{
    r->ok = error_set(r->err, DUET_STATUS_BAD_INPUT,
                      "run %.8s of the store: its %s cannot be; expected what 'duet cluster "
                      "--keep' wrote",
                      r->run->uid, what);
    return false;
}

static bool grow(reading *r)
{
    uint32_t n = r->run->n_seconds;
    if (n & (n - 1)) // full only where it is a power of two, or 0
        return true;
    size_t most = n == 0 ? 1 : 2 * (size_t)n;
    double **const lists[] = {&r->seen, &r->busy_ns, &r->run->object_seconds};
    for (size_t i = 0; r->ok && i < sizeof lists / sizeof *lists; ++i) {
        double *list = realloc(*lists[i], most * sizeof *list);
        r->ok = list || error_set(r->err, DUET_STATUS_NO_MEMORY, "a run's ranks: no memory");
        *lists[i] = list ? list : *lists[i];
    }
    return r->ok;
}

static bool read_rank(void *context, uint32_t number, const profile_cluster_rank *row)
{
    reading *r = context;
    double total_ns = row->busy_ns + row->wait_ns;
    (void)number;
    if (row->n > INT64_MAX || row->ghosts > INT64_MAX || !is_from(row->busy_ns, 0, INFINITY) ||
        !is_from(row->wait_ns, 0, INFINITY) || !isfinite(total_ns))
        return refuse(r, "objects or times of a rank");
    r->are_apart = r->are_apart && row->n == r->run->n && row->ghosts == 0;
    if (row->n == 0 || total_ns == 0)
        return true;
    if (!grow(r))
        return false;
    r->busy_ns[r->run->n_seconds] = row->busy_ns;
    r->seen[r->run->n_seconds++] = (double)row->n + STORED_RUN_GHOST * (double)row->ghosts;
    r->busiest = fmax(r->busiest, row->busy_ns / total_ns);
    return true;
}

// Ranks apart were at work one, two, four and so on at a time, and each tells of the first time
// that it was: the last of each such group tells of as many as there were. Between two numbers of
// ranks what each takes is taken for a line.
static void fill_company(const reading *r)
{
    double *company = r->run->company;
    uint32_t n = r->run->n_seconds;
    company[0] = 1;
    for (uint32_t done = 1; done < n;) {
        uint32_t to = 2 * done < n ? 2 * done : n;
        double before = company[done - 1], step = r->busy_ns[to - 1] / r->busy_ns[0] - before;
        for (uint32_t k = done + 1; k <= to; ++k)
            company[k - 1] = before + step * (k - done) / (to - done);
        done = to;
    }
}

static bool find_company(reading *r)
{
    stored_run *run = r->run;
    run->company = calloc(run->n_seconds, sizeof *run->company);
    if (!run->company)
        return r->ok = error_set(r->err, DUET_STATUS_NO_MEMORY, "a run's ranks: no memory");
    fill_company(r);
    for (uint32_t i = 0; i < run->n_seconds; ++i) {
        run->object_seconds[i] = r->busy_ns[0] * 1e-9 / r->seen[0];
        if (!stored_time_can_be(run->object_seconds[i] * run->company[i]))
            return refuse(r, "time of a step");
    }
    return true;
}

// Where a rank waited longer than the busiest one it waited for that, so the step is as long for
// its objects.
static bool find_seconds(reading *r)
{
    stored_run *run = r->run;
    if (run->n_seconds == 0) {
        r->ok = error_set(r->err, DUET_STATUS_BAD_INPUT,
                          "run %.8s of the store: no rank had an object, so nothing was timed; "
                          "expected a run with objects",
                          run->uid);
        return false;
    }
    if (r->are_apart && run->ranks > 1 && run->n_seconds == run->ranks && run->hosts == 1)
        return find_company(r);
    for (uint32_t i = 0; i < run->n_seconds; ++i) {
        run->object_seconds[i] = r->median_ns * 1e-9 * r->busiest / (double)r->seen[i];
        if (!stored_time_can_be(run->object_seconds[i]))
            return refuse(r, "time of a step");
    }
    return true;
}

static bool read_run(void *context, const cluster_run_entry *e)
{
    reading *r = context;
    stored_run *run = r->run;
    const profile_fabric *f = &e->fabric;
    snprintf(run->uid, sizeof run->uid, "%s", e->uid);
    snprintf(run->scene, sizeof run->scene, "%s", e->run.scene);
    snprintf(run->level, sizeof run->level, "%s", e->run.level);
    run->dims = e->run.dims;
    run->n = e->run.n;
    run->parts = e->run.parts;
    run->resident = e->run.resident;
    run->hosts = f->hosts;
    run->ranks = f->ranks;
    run->latency_ns = f->latency_ns;
    run->byte_ns = f->byte_ns;
    r->median_ns = e->run.median_ns;
    if (f->hosts < 1 || f->ranks < f->hosts || f->ranks > MOST_RANKS)
        return refuse(r, "number of ranks or hosts");
    bool has_network = f->latency_ns != 0 || f->byte_ns != 0;
    if (has_network && (!is_from(f->latency_ns, 1e-3, MOST_LATENCY_NS) ||
                        !is_from(f->byte_ns, 1e-6, MOST_BYTE_NS)))
        return refuse(r, "network's latency or bandwidth");
    r->ok = cluster_rank_each(r->s, e->id, read_rank, r, r->err) && r->ok && find_seconds(r);
    return false;
}

bool stored_run_read(stored_run *run, const char *uid, bool *found, duet_error *err)
{
    char whole[PROFILE_ID];
    *run = (stored_run){0};
    *found = false;
    reading r = {.run = run, .err = err, .are_apart = true, .ok = true};
    r.s = profiles_open(NULL, STORE_READ, err);
    bool ok = r.s && cluster_run_find(r.s, uid, whole, err);
    *found = ok && *whole;
    if (*found)
        ok = cluster_run_each(r.s, whole, read_run, &r, err) && r.ok;
    ok = ok && store_check_read(r.s, err);
    store_close(r.s);
    free(r.seen);
    free(r.busy_ns);
    return ok;
}

void stored_run_end(stored_run *run)
{
    free(run->object_seconds);
    free(run->company);
    *run = (stored_run){0};
}
