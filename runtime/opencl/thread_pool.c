// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // sched_getaffinity
#include "runtime/opencl/thread_pool.h"

#include "base/clock.h"
#include "base/error.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

// Waking from a condition can take 15 microseconds and more, so that what should be over about now
// is looked for first; a thread that stays awake looks for longer than the devices of a step take.
enum { SOON_NS = 50000, AWAKE_NS = 30000000, LOOKS = 1 << 10 };

typedef struct loop {
    thread_pool_some *some;
    void *arg;
    uint64_t n, piece;
    _Atomic uint64_t taken;
} loop;

typedef enum call_state { CALL_NONE, CALL_GIVEN, CALL_TAKEN, CALL_OVER } call_state;

struct thread_pool {
    pthread_mutex_t lock;
    pthread_cond_t given; // a loop, a call, or closing; for sleepers
    pthread_cond_t over;  // a call, or the last piece of a loop; for the caller
    atomic_uint sleepers;
    _Atomic bool caller_sleeps;
    _Atomic uint64_t n_loops; // given so far
    _Atomic(loop *) now;      // NULL: none that may still be joined
    atomic_uint inside;       // threads that may have joined it
    thread_pool_job *job;     // thread_pool_start's
    void *job_arg;
    loop jobs; // the loop that calls it
    thread_pool_job *call;
    void *call_arg;
    atomic_int call_state;
    _Atomic bool awake, closing;
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

typedef bool condition(thread_pool *c, uint64_t seen);

static bool has_work(thread_pool *c, uint64_t seen)
{
    return atomic_load(&c->n_loops) != seen || atomic_load(&c->call_state) == CALL_GIVEN ||
           atomic_load(&c->closing);
}

static bool is_call_over(thread_pool *c, uint64_t unused)
{
    (void)unused;
    return atomic_load(&c->call_state) == CALL_OVER;
}

static bool is_loop_over(thread_pool *c, uint64_t unused)
{
    (void)unused;
    return atomic_load(&c->inside) == 0;
}

static bool look_for(thread_pool *c, condition *is, uint64_t seen, uint64_t ns)
{
    for (uint64_t begun = clock_steady_ns(); clock_steady_ns() - begun < ns; sched_yield())
        for (int i = 0; i < LOOKS; ++i)
            if (is(c, seen))
                return true;
    return is(c, seen);
}

// Either the giver sees the sleeper or the sleeper sees the work.
static void wait_for_work(thread_pool *c, uint64_t seen)
{
    if (look_for(c, has_work, seen, atomic_load(&c->awake) ? AWAKE_NS : 0))
        return;
    pthread_mutex_lock(&c->lock);
    atomic_fetch_add(&c->sleepers, 1);
    while (!has_work(c, seen))
        pthread_cond_wait(&c->given, &c->lock);
    atomic_fetch_sub(&c->sleepers, 1);
    pthread_mutex_unlock(&c->lock);
}

static void wait_until(thread_pool *c, condition *is_over)
{
    if (look_for(c, is_over, 0, atomic_load(&c->awake) ? AWAKE_NS : SOON_NS))
        return;
    pthread_mutex_lock(&c->lock);
    atomic_store(&c->caller_sleeps, true);
    while (!is_over(c, 0))
        pthread_cond_wait(&c->over, &c->lock);
    atomic_store(&c->caller_sleeps, false);
    pthread_mutex_unlock(&c->lock);
}

static void wake(thread_pool *c, pthread_cond_t *what, bool sleeps)
{
    if (!sleeps)
        return;
    pthread_mutex_lock(&c->lock);
    pthread_cond_broadcast(what);
    pthread_mutex_unlock(&c->lock);
}

static void give(thread_pool *c)
{
    wake(c, &c->given, atomic_load(&c->sleepers) > 0);
}

// ---------------------------------------------------------------- threads

static void run_pieces(loop *l)
{
    uint64_t at;
    while ((at = atomic_fetch_add(&l->taken, l->piece)) < l->n)
        l->some(l->arg, at, l->n - at < l->piece ? l->n : at + l->piece);
}

static void join_loop(thread_pool *c)
{
    atomic_fetch_add(&c->inside, 1);
    loop *now = atomic_load(&c->now);
    if (now)
        run_pieces(now);
    atomic_fetch_sub(&c->inside, 1);
    wake(c, &c->over, atomic_load(&c->caller_sleeps));
}

static void make_call(thread_pool *c)
{
    int given = CALL_GIVEN;
    if (!atomic_compare_exchange_strong(&c->call_state, &given, CALL_TAKEN))
        return;
    c->call(c->call_arg);
    atomic_store(&c->call_state, CALL_OVER);
    wake(c, &c->over, atomic_load(&c->caller_sleeps));
}

static void *work(void *arg)
{
    thread_pool *c = arg;
    for (uint64_t seen = 0; !atomic_load(&c->closing); wait_for_work(c, seen)) {
        seen = atomic_load(&c->n_loops);
        make_call(c);
        join_loop(c);
    }
    return NULL;
}

thread_pool *thread_pool_open(uint32_t n_threads, duet_error *err)
{
    thread_pool *c = calloc(1, sizeof *c + n_threads * sizeof c->threads[0]);
    if (!c)
        return error_null(err, DUET_STATUS_NO_MEMORY, "no memory for %u threads", n_threads);
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->given, NULL);
    pthread_cond_init(&c->over, NULL);
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
    atomic_store(&c->closing, true);
    give(c);
    for (uint32_t i = 0; i < c->n_threads; ++i)
        pthread_join(c->threads[i], NULL);
    pthread_cond_destroy(&c->given);
    pthread_cond_destroy(&c->over);
    pthread_mutex_destroy(&c->lock);
    free(c);
}

void thread_pool_stay_awake(thread_pool *c, bool awake)
{
    atomic_store(&c->awake, awake);
}

// ---------------------------------------------------------------- loops

static void begin_loop(thread_pool *c, loop *l)
{
    atomic_store(&c->now, l);
    atomic_fetch_add(&c->n_loops, 1);
    give(c);
}

static void end_loop(thread_pool *c, loop *l)
{
    run_pieces(l);
    atomic_store(&c->now, NULL);
    wait_until(c, is_loop_over);
}

void thread_pool_share(thread_pool *c, thread_pool_some *some, void *arg, uint64_t n,
                       uint64_t piece)
{
    loop l = {.some = some, .arg = arg, .n = n, .piece = piece};
    bool shared = c && n > piece;
    if (shared)
        begin_loop(c, &l);
    if (shared)
        end_loop(c, &l);
    else
        run_pieces(&l);
}

static void do_job(void *arg, uint64_t first, uint64_t last)
{
    const thread_pool *c = arg;
    for (; first < last; ++first)
        c->job(c->job_arg);
}

void thread_pool_start(thread_pool *c, thread_pool_job *job, void *arg)
{
    c->job = job;
    c->job_arg = arg;
    c->jobs.some = do_job;
    c->jobs.arg = c;
    c->jobs.n = c->n_threads;
    c->jobs.piece = 1;
    atomic_store(&c->jobs.taken, 0);
    begin_loop(c, &c->jobs);
}

void thread_pool_wait(thread_pool *c)
{
    if (c)
        end_loop(c, &c->jobs);
}

void thread_pool_run_both(thread_pool *c, thread_pool_job *job, void *a, void *b)
{
    if (a && b)
        thread_pool_start(c, job, a);
    else if (a)
        job(a);
    if (b)
        job(b);
    if (a && b)
        thread_pool_wait(c);
}

// ---------------------------------------------------------------- a call

void thread_pool_begin_call(thread_pool *c, thread_pool_job *call, void *arg)
{
    c->call = call;
    c->call_arg = arg;
    atomic_store(&c->call_state, CALL_GIVEN);
    give(c);
}

void thread_pool_end_call(thread_pool *c)
{
    make_call(c);
    wait_until(c, is_call_over);
    atomic_store(&c->call_state, CALL_NONE);
}
