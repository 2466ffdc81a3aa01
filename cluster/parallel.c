// SPDX-License-Identifier: MIT
#include "cluster/parallel.h"

#include "runtime/opencl/thread_pool.h"

#include <math.h>
#include <string.h>

// Objects below which waking a thread costs more than it brings.
enum { LEAST = 1 << 12 };

// Processors may be a sum of many parts, and a little less than whole.
#define ROUNDING 1e-6

bool parallel_begin(parallel *p, double processors, uint32_t least, duet_error *err)
{
    double whole = floor(processors + ROUNDING);
    *p = (parallel){.n = (uint32_t)fmin(fmax(whole, least), PARALLEL_MOST),
                    .is_oversubscribed = whole < least};
    if (p->n > 1)
        p->team = thread_pool_open(p->n - 1, err);
    return p->n == 1 || p->team;
}

void parallel_end(parallel *p)
{
    thread_pool_close(p->team);
    *p = (parallel){0};
}

void parallel_stay_awake(parallel *p, bool awake)
{
    if (p->team)
        thread_pool_stay_awake(p->team, awake && !p->is_oversubscribed);
}

// ---------------------------------------------------------------- loops

typedef struct parts {
    parallel_body *body;
    void *context;
    uint64_t n;
    uint32_t n_parts;
} parts;

static void run_parts(void *arg, uint64_t first, uint64_t last)
{
    const parts *p = arg;
    uint64_t each = p->n / p->n_parts;
    for (uint64_t part = first; part < last; ++part)
        p->body(p->context, (uint32_t)part, each * part,
                part + 1 == p->n_parts ? p->n : each * (part + 1));
}

// More parts than threads, so that one that is late or slow takes fewer.
uint32_t parallel_each(parallel *p, uint64_t n, parallel_body *body, void *context)
{
    thread_pool *team = n >= LEAST ? p->team : NULL;
    parts all = {body, context, n, team ? PARALLEL_MOST : 1};
    thread_pool_share(team, run_parts, &all, all.n_parts, 1);
    return all.n_parts;
}

void parallel_jobs(parallel *p, uint32_t n, parallel_body *body, void *context)
{
    parts all = {body, context, n, n};
    thread_pool_share(p ? p->team : NULL, run_parts, &all, n, 1);
}

// ---------------------------------------------------------------- rows

typedef struct copying {
    unsigned char *to;
    const unsigned char *from;
    size_t bytes;
} copying;

static void copy_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const copying *c = context;
    (void)part;
    if (first < end)
        memcpy(c->to + first * c->bytes, c->from + first * c->bytes, (end - first) * c->bytes);
}

void parallel_copy(parallel *p, void *to, const void *from, uint64_t n, size_t bytes)
{
    copying c = {to, from, bytes};
    parallel_each(p, n, copy_part, &c);
}
