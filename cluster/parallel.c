// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cluster/parallel.h"

#include "base/clock.h"
#include "base/error.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

// Objects below which waking a thread costs more than it brings; how long a keen one looks for a
// loop, which is longer than the devices of a step take; and how often before others may run.
enum { LEAST = 1 << 12, KEEN_MS = 30, LOOKS = 1 << 10 };

typedef struct loop {
    parallel_body *body;
    void *context;
    uint64_t n;
    uint32_t n_parts;
    atomic_uint next; // part
} loop;

typedef enum call_state { CALL_NONE, CALL_GIVEN, CALL_TAKEN, CALL_OVER } call_state;

typedef struct team team;

struct team {
    pthread_mutex_t lock;
    pthread_cond_t given; // a loop, a call, or closing; for sleepers
    pthread_cond_t over;  // a call
    atomic_uint sleepers;
    parallel_call *call;
    void *call_context;
    atomic_int call_state;
    _Atomic uint64_t n_loops;   // given so far
    _Atomic(struct loop *) now; // NULL: none that may still be joined
    atomic_uint inside;         // threads that may have joined it
    atomic_bool keen, closing;
    uint32_t n_threads;
    pthread_t threads[];
};

// More parts than threads, so that one that is late or slow takes fewer.
static void run_parts(loop *l)
{
    uint64_t each = l->n / l->n_parts;
    uint32_t part;
    while ((part = atomic_fetch_add(&l->next, 1)) < l->n_parts)
        l->body(l->context, part, each * part, part + 1 == l->n_parts ? l->n : each * (part + 1));
}

// ---------------------------------------------------------------- threads

static bool has_news(team *t, uint64_t seen)
{
    return atomic_load(&t->n_loops) != seen || atomic_load(&t->call_state) == CALL_GIVEN ||
           atomic_load(&t->closing);
}

static void make_call(team *t)
{
    int given = CALL_GIVEN;
    if (!atomic_compare_exchange_strong(&t->call_state, &given, CALL_TAKEN))
        return;
    t->call(t->call_context);
    pthread_mutex_lock(&t->lock);
    atomic_store(&t->call_state, CALL_OVER);
    pthread_cond_signal(&t->over);
    pthread_mutex_unlock(&t->lock);
}

static bool is_over(team *t, uint64_t unused)
{
    (void)unused;
    return atomic_load(&t->call_state) == CALL_OVER;
}

static void look_out(team *t, bool (*comes)(team *t, uint64_t seen), uint64_t seen)
{
    uint64_t begun = clock_steady_ns();
    while (atomic_load(&t->keen) && clock_ms_since(begun) < KEEN_MS) {
        for (int i = 0; i < LOOKS; ++i)
            if (comes(t, seen))
                return;
        sched_yield();
    }
}

// Who gives a loop sees a sleeper, or the sleeper sees the loop.
static void sleep_until_news(team *t, uint64_t seen)
{
    pthread_mutex_lock(&t->lock);
    atomic_fetch_add(&t->sleepers, 1);
    while (!has_news(t, seen))
        pthread_cond_wait(&t->given, &t->lock);
    atomic_fetch_sub(&t->sleepers, 1);
    pthread_mutex_unlock(&t->lock);
}

static void wake(team *t)
{
    if (atomic_load(&t->sleepers) == 0)
        return;
    pthread_mutex_lock(&t->lock);
    pthread_cond_broadcast(&t->given);
    pthread_mutex_unlock(&t->lock);
}

static void *work(void *arg)
{
    team *t = arg;
    for (uint64_t seen = 0; !atomic_load(&t->closing); seen = atomic_load(&t->n_loops)) {
        make_call(t);
        atomic_fetch_add(&t->inside, 1);
        loop *now = atomic_load(&t->now);
        if (now)
            run_parts(now);
        atomic_fetch_sub(&t->inside, 1);
        if (!has_news(t, seen))
            look_out(t, has_news, seen);
        if (!has_news(t, seen))
            sleep_until_news(t, seen);
    }
    return NULL;
}

static void close_team(team *t)
{
    if (!t)
        return;
    atomic_store(&t->closing, true);
    wake(t);
    for (uint32_t i = 0; i < t->n_threads; ++i)
        pthread_join(t->threads[i], NULL);
    pthread_cond_destroy(&t->given);
    pthread_cond_destroy(&t->over);
    pthread_mutex_destroy(&t->lock);
    free(t);
}

static team *open_team(uint32_t n, duet_error *err)
{
    team *t = calloc(1, sizeof *t + n * sizeof t->threads[0]);
    if (!t) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%u threads: no memory", n);
        return NULL;
    }
    pthread_mutex_init(&t->lock, NULL);
    pthread_cond_init(&t->given, NULL);
    pthread_cond_init(&t->over, NULL);
    while (t->n_threads < n && pthread_create(&t->threads[t->n_threads], NULL, work, t) == 0)
        ++t->n_threads;
    if (t->n_threads == n)
        return t;
    error_set(err, DUET_STATUS_NO_MEMORY, "the system gives %u of %u threads", t->n_threads, n);
    close_team(t);
    return NULL;
}

// ---------------------------------------------------------------- loops

// Processors may be a sum of many parts, and a little less than whole.
#define ROUNDING 1e-6

bool parallel_begin(parallel *p, double processors, uint32_t least, duet_error *err)
{
    double whole = floor(processors + ROUNDING);
    *p = (parallel){.n = (uint32_t)fmin(fmax(whole, least), PARALLEL_MOST),
                    .is_crowded = whole < least};
    if (p->n > 1)
        p->team = open_team(p->n - 1, err);
    return p->n == 1 || p->team;
}

void parallel_end(parallel *p)
{
    close_team(p->team);
    *p = (parallel){0};
}

void parallel_be_keen(parallel *p, bool keen)
{
    if (p->team)
        atomic_store(&p->team->keen, keen && !p->is_crowded);
}

static void run_by(team *t, loop *l)
{
    if (t) {
        atomic_store(&t->now, l);
        atomic_fetch_add(&t->n_loops, 1);
        wake(t);
    }
    run_parts(l);
    if (t) {
        atomic_store(&t->now, NULL);
        while (atomic_load(&t->inside) > 0)
            sched_yield();
    }
}

uint32_t parallel_each(parallel *p, uint64_t n, parallel_body *body, void *context)
{
    team *t = n >= LEAST ? p->team : NULL;
    loop l = {.body = body, .context = context, .n = n, .n_parts = t ? PARALLEL_MOST : 1};
    run_by(t, &l);
    return l.n_parts;
}

void parallel_jobs(parallel *p, uint32_t n, parallel_body *body, void *context)
{
    loop l = {.body = body, .context = context, .n = n, .n_parts = n};
    if (n > 0)
        run_by(p && n > 1 ? p->team : NULL, &l);
}

// ---------------------------------------------------------------- a call

void parallel_call_begin(parallel *p, parallel_call *call, void *context)
{
    team *t = p->team;
    if (!t) {
        call(context);
        return;
    }
    t->call = call;
    t->call_context = context;
    atomic_store(&t->call_state, CALL_GIVEN);
    wake(t);
}

void parallel_call_end(parallel *p)
{
    team *t = p->team;
    if (!t)
        return;
    make_call(t);
    look_out(t, is_over, 0);
    pthread_mutex_lock(&t->lock);
    while (!is_over(t, 0))
        pthread_cond_wait(&t->over, &t->lock);
    pthread_mutex_unlock(&t->lock);
    atomic_store(&t->call_state, CALL_NONE);
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
