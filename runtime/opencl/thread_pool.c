// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // sched_getaffinity
#include "runtime/opencl/thread_pool.h"

#include "base/clock.h"
#include "base/error.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

struct thread_pool {
    pthread_mutex_t lock;
    pthread_cond_t given; // a job, or closing
    pthread_cond_t done;  // by all
    void (*job)(void *);
    void *arg;
    uint64_t n_jobs; // given so far
    uint32_t n_busy; // threads that have not finished the last one
    bool closing;
    uint32_t n_threads;
    pthread_t threads[];
};

static void *work(void *arg)
{
    thread_pool *c = arg;
    uint64_t n_done = 0;
    pthread_mutex_lock(&c->lock);
    while (!c->closing || n_done < c->n_jobs) {
        if (n_done == c->n_jobs) {
            pthread_cond_wait(&c->given, &c->lock);
            continue;
        }
        ++n_done;
        pthread_mutex_unlock(&c->lock);
        c->job(c->arg);
        pthread_mutex_lock(&c->lock);
        if (--c->n_busy == 0)
            pthread_cond_signal(&c->done);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

uint32_t thread_pool_spare(uint32_t most)
{
    cpu_set_t cpus;
    int n = sched_getaffinity(0, sizeof cpus, &cpus) == 0 ? CPU_COUNT(&cpus) : 1;
    uint32_t spare = n <= 3 ? 1 : (uint32_t)n - 2;
    return spare < most ? spare : most;
}

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err)
{
    thread_pool *c = calloc(1, sizeof *c + n_threads * sizeof c->threads[0]);
    if (!c)
        return error_null(err, DUET_STATUS_NO_MEMORY, "no memory for %u threads", n_threads);
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->given, NULL);
    pthread_cond_init(&c->done, NULL);
    while (c->n_threads < n_threads &&
           pthread_create(&c->threads[c->n_threads], NULL, work, c) == 0)
        ++c->n_threads;
    if (c->n_threads == n_threads)
        return c;
    error_set(err, DUET_STATUS_NO_MEMORY, "the system gives %u of %u threads", c->n_threads,
              n_threads);
    thread_pool_close(c);
    return NULL;
}

void thread_pool_close(thread_pool *c)
{
    if (!c)
        return;
    pthread_mutex_lock(&c->lock);
    c->closing = true;
    pthread_cond_broadcast(&c->given);
    pthread_mutex_unlock(&c->lock);
    for (uint32_t i = 0; i < c->n_threads; ++i)
        pthread_join(c->threads[i], NULL);
    pthread_cond_destroy(&c->given);
    pthread_cond_destroy(&c->done);
    pthread_mutex_destroy(&c->lock);
    free(c);
}

void thread_pool_start(thread_pool *c, void (*job)(void *), void *arg)
{
    pthread_mutex_lock(&c->lock);
    c->job = job;
    c->arg = arg;
    c->n_busy = c->n_threads;
    ++c->n_jobs;
    pthread_cond_broadcast(&c->given);
    pthread_mutex_unlock(&c->lock);
}

void thread_pool_wait(thread_pool *c)
{
    if (!c)
        return;
    pthread_mutex_lock(&c->lock);
    while (c->n_busy > 0)
        pthread_cond_wait(&c->done, &c->lock);
    pthread_mutex_unlock(&c->lock);
}

static bool is_busy(thread_pool *c)
{
    pthread_mutex_lock(&c->lock);
    bool busy = c->n_busy > 0;
    pthread_mutex_unlock(&c->lock);
    return busy;
}

// Waking from thread_pool_wait can take 15 microseconds and more.
enum { SOON_NS = 50000 };

// For a thread that should be done about now.
static void wait_awake(thread_pool *c)
{
    for (uint64_t begun = clock_steady_ns(); is_busy(c) && clock_steady_ns() - begun < SOON_NS;)
        sched_yield();
    thread_pool_wait(c);
}

void thread_pool_run_both(thread_pool *c, void (*job)(void *), void *a, void *b)
{
    if (a && b)
        thread_pool_start(c, job, a);
    else if (a)
        job(a);
    if (b)
        job(b);
    if (a && b)
        wait_awake(c);
}

typedef struct sharing {
    thread_pool_some *some;
    void *arg;
    uint64_t n, piece;
    _Atomic uint64_t taken;
} sharing;

static void do_pieces(void *arg)
{
    sharing *s = arg;
    uint64_t at;
    while ((at = atomic_fetch_add(&s->taken, s->piece)) < s->n)
        s->some(s->arg, at, s->n - at < s->piece ? s->n : at + s->piece);
}

void thread_pool_share(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n,
                       uint64_t piece)
{
    sharing s = {.some = some, .arg = arg, .n = n, .piece = piece};
    bool shared = c && n > piece;
    if (shared)
        thread_pool_start(c, do_pieces, &s);
    do_pieces(&s);
    if (shared)
        thread_pool_wait(c);
}
