// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // sched_getaffinity
#include "runtime/opencl/thread_pool.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/plain_numbers.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

// Waking from a condition can take 15 microseconds and more, so that what should be over about now
// is looked for first; a thread that stays awake looks for longer than the devices of a step take.
enum { SOON_NS = 50000, AWAKE_NS = 30000000, LOOKS = 1 << 10 };

// Pieces of [0, n), or one job.
typedef struct loop {
    thread_pool_some *some;
    thread_pool_job *job; // NULL: pieces
    void *arg;
    uint64_t n, piece;
    _Atomic uint64_t taken;
} loop;

// A loop and a call can be under way at a time. Threads may join `now` until it is NULL, and are
// inside for as long as they may still read it.
typedef struct slot {
    _Atomic(loop *) now;
    atomic_uint inside;
    loop started; // by thread_pool_start or thread_pool_begin_call
} slot;

enum { CALL, LOOP, SLOTS };

typedef enum pool_mode { POOL_SLEEPS, POOL_AWAKE, POOL_CLOSING } pool_mode;

// Threads that sleep until somebody wakes them.
typedef struct sleepers {
    pthread_cond_t woken;
    atomic_uint n;
} sleepers;

struct thread_pool {
    pthread_mutex_t lock;
    sleepers idle;   // threads without work
    sleepers caller; // who waits for the last thread inside a slot
    slot slots[SLOTS];
    _Atomic uint64_t n_given; // loops and calls so far
    atomic_int mode;          // a pool_mode
    uint32_t n_threads;
    pthread_t threads[];
};

uint32_t thread_pool_spare(uint32_t most)
{
    cpu_set_t cpus;
    int n = sched_getaffinity(0, sizeof cpus, &cpus) == 0 ? CPU_COUNT(&cpus) : 1;
    uint32_t spare = n <= 3 ? 1 : (uint32_t)n - 2;
    return spare < most ? spare : most;
}

// ---------------------------------------------------------------- waiting

typedef bool condition(thread_pool *c, uint64_t which);

static bool is_mode(thread_pool *c, pool_mode mode)
{
    return atomic_load(&c->mode) == (int)mode;
}

static bool has_work(thread_pool *c, uint64_t seen)
{
    return atomic_load(&c->n_given) != seen || is_mode(c, POOL_CLOSING);
}

static bool is_over(thread_pool *c, uint64_t which)
{
    return atomic_load(&c->slots[which].inside) == 0;
}

static bool look_for(thread_pool *c, condition *is, uint64_t which, uint64_t ns)
{
    for (uint64_t begun = clock_steady_ns(); clock_steady_ns() - begun < ns; sched_yield())
        for (int i = 0; i < LOOKS; ++i)
            if (is(c, which))
                return true;
    return is(c, which);
}

// Either the one who makes the condition true sees the sleeper, or the sleeper sees that it is.
static void wait_until(thread_pool *c, sleepers *as, condition *is, uint64_t which, uint64_t ns)
{
    if (look_for(c, is, which, is_mode(c, POOL_AWAKE) ? AWAKE_NS : ns))
        return;
    pthread_mutex_lock(&c->lock);
    atomic_fetch_add(&as->n, 1);
    while (!is(c, which))
        pthread_cond_wait(&as->woken, &c->lock);
    atomic_fetch_sub(&as->n, 1);
    pthread_mutex_unlock(&c->lock);
}

static void wake(thread_pool *c, sleepers *who)
{
    if (atomic_load(&who->n) == 0)
        return;
    pthread_mutex_lock(&c->lock);
    pthread_cond_broadcast(&who->woken);
    pthread_mutex_unlock(&c->lock);
}

// ---------------------------------------------------------------- threads

static void run_pieces(loop *l)
{
    uint64_t at;
    while ((at = atomic_fetch_add(&l->taken, l->piece)) < l->n)
        if (l->job)
            l->job(l->arg);
        else
            l->some(l->arg, at, l->n - at < l->piece ? l->n : at + l->piece);
}

static void join(thread_pool *c, slot *s)
{
    atomic_fetch_add(&s->inside, 1);
    loop *now = atomic_load(&s->now);
    if (now) {
        void *numbers = plain_numbers_begin();
        run_pieces(now);
        plain_numbers_end(numbers);
    }
    atomic_fetch_sub(&s->inside, 1);
    wake(c, &c->caller);
}

static void *work(void *arg)
{
    thread_pool *c = arg;
    for (uint64_t seen = 0; !is_mode(c, POOL_CLOSING); wait_until(c, &c->idle, has_work, seen, 0)) {
        seen = atomic_load(&c->n_given);
        for (int i = 0; i < SLOTS; ++i)
            join(c, &c->slots[i]);
    }
    return NULL;
}

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err)
{
    thread_pool *c = calloc(1, sizeof *c + n_threads * sizeof c->threads[0]);
    if (!c)
        return null_no_memory(err, "%u threads", n_threads);
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->idle.woken, NULL);
    pthread_cond_init(&c->caller.woken, NULL);
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
    thread_pool_wait(c);
    atomic_store(&c->mode, POOL_CLOSING);
    wake(c, &c->idle);
    for (uint32_t i = 0; i < c->n_threads; ++i)
        pthread_join(c->threads[i], NULL);
    pthread_cond_destroy(&c->idle.woken);
    pthread_cond_destroy(&c->caller.woken);
    pthread_mutex_destroy(&c->lock);
    free(c);
}

void thread_pool_stay_awake(thread_pool *c, bool awake)
{
    atomic_store(&c->mode, awake ? POOL_AWAKE : POOL_SLEEPS);
}

// ---------------------------------------------------------------- loops and calls

static void begin(thread_pool *c, slot *s, loop *l)
{
    atomic_store(&s->now, l);
    atomic_fetch_add(&c->n_given, 1);
    wake(c, &c->idle);
}

static void end(thread_pool *c, slot *s, loop *l)
{
    run_pieces(l);
    atomic_store(&s->now, NULL);
    wait_until(c, &c->caller, is_over, (uint64_t)(s - c->slots), SOON_NS);
}

void thread_pool_share(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n,
                       uint64_t piece)
{
    loop l = {.some = some, .arg = arg, .n = n, .piece = piece};
    if (!c || n <= piece) {
        run_pieces(&l);
        return;
    }
    begin(c, &c->slots[LOOP], &l);
    end(c, &c->slots[LOOP], &l);
}

static void start(thread_pool *c, slot *s, loop l)
{
    s->started = (loop){.some = l.some, .job = l.job, .arg = l.arg, .n = l.n, .piece = 1};
    begin(c, s, &s->started);
}

void thread_pool_start(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n)
{
    start(c, &c->slots[LOOP], (loop){.some = some, .arg = arg, .n = n});
}

void thread_pool_wait(thread_pool *c)
{
    if (c)
        end(c, &c->slots[LOOP], &c->slots[LOOP].started);
}

void thread_pool_run_both(thread_pool *c, thread_pool_job *job, void *a, void *b)
{
    if (a && b)
        start(c, &c->slots[LOOP], (loop){.job = job, .arg = a, .n = 1});
    else if (a)
        job(a);
    if (b)
        job(b);
    if (a && b)
        thread_pool_wait(c);
}

void thread_pool_begin_call(thread_pool *c, thread_pool_job *call, void *arg)
{
    start(c, &c->slots[CALL], (loop){.job = call, .arg = arg, .n = 1});
}

void thread_pool_end_call(thread_pool *c)
{
    end(c, &c->slots[CALL], &c->slots[CALL].started);
}
