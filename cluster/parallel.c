// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "cluster/parallel.h"

#include "runtime/opencl/thread_pool.h"

#include <sched.h>
#include <stdatomic.h>

enum { LEAST = 1 << 14 }; // of objects, below which starting a thread costs more than it brings

bool parallel_begin(parallel *p, int n_on_host, duet_error *err)
{
    cpu_set_t own;
    int processors = sched_getaffinity(0, sizeof own, &own) == 0 ? CPU_COUNT(&own) : 1;
    int threads = processors / n_on_host;
    *p = (parallel){.n = threads < 1               ? 1
                         : threads > PARALLEL_MOST ? PARALLEL_MOST
                                                   : (uint32_t)threads};
    if (p->n > 1)
        p->pool = thread_pool_open(p->n, err);
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
    atomic_uint next;
} loop;

static void run_part(void *arg)
{
    loop *l = arg;
    uint32_t part = atomic_fetch_add(&l->next, 1);
    l->body(l->context, part, l->n / l->n_parts * part,
            part + 1 == l->n_parts ? l->n : l->n / l->n_parts * (part + 1));
}

uint32_t parallel_each(parallel *p, uint64_t n, parallel_body *body, void *context)
{
    loop l = {.body = body, .context = context, .n = n, .n_parts = 1};
    if (!p->pool || n < LEAST) {
        run_part(&l);
        return 1;
    }
    l.n_parts = p->n;
    thread_pool_start(p->pool, run_part, &l);
    thread_pool_wait(p->pool);
    return l.n_parts;
}
