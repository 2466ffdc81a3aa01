// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "cluster/parallel.h"

#include "runtime/opencl/thread_pool.h"

#include <sched.h>

enum { LEAST = 1 << 12 }; // of objects, below which starting a thread costs more than it brings

bool parallel_begin(parallel *p, int n_on_host, duet_error *err)
{
    cpu_set_t own;
    int processors = sched_getaffinity(0, sizeof own, &own) == 0 ? CPU_COUNT(&own) : 1;
    int threads = processors / n_on_host;
    *p = (parallel){.n = threads < 1               ? 1
                         : threads > PARALLEL_MOST ? PARALLEL_MOST
                                                   : (uint32_t)threads};
    if (p->n > 1)
        p->pool = thread_pool_open(p->n - 1, err);
    return p->n == 1 || p->pool;
}

void parallel_end(parallel *p)
{
    thread_pool_close(p->pool);
    *p = (parallel){0};
}

typedef struct loop {
    parallel_body *body;
    void *context;
    uint64_t n;
    uint32_t n_parts;
} loop;

static void run_parts(void *arg, uint64_t first, uint64_t last)
{
    const loop *l = arg;
    uint64_t each = l->n / l->n_parts;
    for (uint64_t part = first; part < last; ++part)
        l->body(l->context, (uint32_t)part, each * part,
                part + 1 == l->n_parts ? l->n : each * (part + 1));
}

// More parts than threads, so that one that starts late or is slow takes fewer.
uint32_t parallel_each(parallel *p, uint64_t n, parallel_body *body, void *context)
{
    loop l = {.body = body, .context = context, .n = n, .n_parts = 1};
    if (p->pool && n >= LEAST)
        l.n_parts = PARALLEL_MOST;
    thread_pool_share(p->pool, run_parts, &l, l.n_parts, 1);
    return l.n_parts;
}
