// SPDX-License-Identifier: MIT
// Threads sleep between stages rather than spin: a spinning thread would hide
// how many processors the stage itself really had.
#define _POSIX_C_SOURCE 200809L
#include "workers.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>

typedef struct worker {
    workers *all;
    pthread_t thread;
    uint64_t cpu_ns;
    uint32_t index;
} worker;

struct workers {
    pthread_barrier_t begin;
    pthread_barrier_t end;
    stage_part *part; // NULL: leave
    void *context;
    uint32_t n;
    worker each[];
};

static uint64_t thread_cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static void do_part(worker *w)
{
    uint64_t begun = thread_cpu_ns();
    w->all->part(w->all->context, w->index);
    w->cpu_ns += thread_cpu_ns() - begun;
}

static void *follow(void *argument)
{
    worker *w = argument;
    for (;;) {
        pthread_barrier_wait(&w->all->begin);
        if (!w->all->part)
            return NULL;
        do_part(w);
        pthread_barrier_wait(&w->all->end);
    }
}

workers *workers_open(uint32_t n)
{
    workers *w = calloc(1, sizeof *w + n * sizeof w->each[0]);
    if (!w)
        return NULL;
    w->n = n;
    pthread_barrier_init(&w->begin, NULL, n);
    pthread_barrier_init(&w->end, NULL, n);
    for (uint32_t i = 0; i < n; ++i)
        w->each[i] = (worker){.all = w, .index = i};
    for (uint32_t i = 1; i < n; ++i)
        if (pthread_create(&w->each[i].thread, NULL, follow, &w->each[i]) != 0)
            abort(); // a barrier cannot be left by half of its threads
    return w;
}

void workers_run(workers *w, stage_part *part, void *context)
{
    w->part = part;
    w->context = context;
    pthread_barrier_wait(&w->begin);
    do_part(&w->each[0]);
    pthread_barrier_wait(&w->end);
}

uint64_t workers_cpu_ns(const workers *w)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < w->n; ++i)
        sum += w->each[i].cpu_ns;
    return sum;
}

void workers_close(workers *w)
{
    if (!w)
        return;
    w->part = NULL;
    pthread_barrier_wait(&w->begin);
    for (uint32_t i = 1; i < w->n; ++i)
        pthread_join(w->each[i].thread, NULL);
    pthread_barrier_destroy(&w->begin);
    pthread_barrier_destroy(&w->end);
    free(w);
}
