// SPDX-License-Identifier: MIT
// How long a cluster's step takes where there are many objects: unit cubes at places that follow
// from their ids, written by all threads, so that 10^9 of them are there in seconds.
//
//   duet_bench_cluster OBJECTS PARTS [STEPS [PAIR]]
//
// It uses what any application can, and is compiled as one: cc steps.c $(pkg-config --cflags --libs
// duet_cluster) -lm.
#define _GNU_SOURCE // sched_getaffinity
#include "duet_cluster.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

enum { MOST_THREADS = 256, MOST_STEPS = 100 };

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// ---------------------------------------------------------------- objects

// From 0 to 1.
static float fraction_of(uint64_t id, uint64_t number)
{
    uint64_t k = (8 * id + number) * UINT64_C(0x9e3779b97f4a7c15);
    k = (k ^ k >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    k = (k ^ k >> 27) * UINT64_C(0x94d049bb133111eb);
    return (float)(k >> 40) * 0x1p-24f;
}

// Makes a scene as dense as the paper's.
static duet_pose pose_of(uint64_t id, float world)
{
    duet_pose p = {.half_extents = {0.5f, 0.5f, 0.5f}};
    for (uint64_t k = 0; k < 3; ++k)
        p.centre[k] = world * fraction_of(id, k);
    for (uint64_t k = 0; k < 4; ++k)
        p.rotation[k] = fraction_of(id, 3 + k) + 0x1p-24f;
    return p;
}

typedef struct writing {
    uint64_t *ids; // NULL: they are there
    const uint64_t *of;
    duet_pose *poses;
    uint64_t first, end;
    float world;
} writing;

static void *write_some(void *arg)
{
    const writing *w = arg;
    for (uint64_t i = w->first; i < w->end; ++i) {
        if (w->ids)
            w->ids[i] = i;
        w->poses[i] = pose_of(w->of ? w->of[i] : i, w->world);
    }
    return NULL;
}

static void write_all(writing all, uint64_t n)
{
    cpu_set_t own;
    pthread_t threads[MOST_THREADS];
    writing parts[MOST_THREADS];
    int count = sched_getaffinity(0, sizeof own, &own) == 0 ? CPU_COUNT(&own) : 1;
    count = count < MOST_THREADS ? count : MOST_THREADS;
    for (int i = 0; i < count; ++i) {
        parts[i] = all;
        parts[i].first = n * (uint64_t)i / (uint64_t)count;
        parts[i].end = n * (uint64_t)(i + 1) / (uint64_t)count;
        if (pthread_create(&threads[i], NULL, write_some, &parts[i]) != 0)
            abort();
    }
    for (int i = 0; i < count; ++i)
        pthread_join(threads[i], NULL);
}

static bool give_objects(duet_cluster *c, uint64_t n, float world, duet_error *err)
{
    writing w = {.world = world};
    w.ids = malloc(n * sizeof *w.ids);
    w.poses = malloc(n * sizeof *w.poses);
    bool ok = w.ids && w.poses;
    if (!ok)
        snprintf(err->text, sizeof err->text, "%llu objects: no memory", (unsigned long long)n);
    if (ok)
        write_all(w, n);
    ok = ok && duet_cluster_set_objects(c, DUET_OBJECT_POSES, w.ids, w.poses, (uint32_t)n, err);
    free(w.ids);
    free(w.poses);
    return ok;
}

// ---------------------------------------------------------------- steps

static int ascending(const void *left, const void *right)
{
    double p = *(const double *)left, q = *(const double *)right;
    return (p > q) - (p < q);
}

static double rss_gb(void)
{
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    return (double)used.ru_maxrss * 1024 * 1e-9;
}

// Mapped objects are new to the devices; it is not timed how long the application writes it.
static bool run(duet_cluster *c, int steps, duet_error *err)
{
    double ms[MOST_STEPS];
    duet_cluster_result r = {0};
    for (int i = -1; i < steps; ++i) { // kernels are compiled in the first
        const uint64_t *ids;
        uint32_t n;
        double begun = seconds_now();
        if ((i >= 0 && !duet_cluster_map_owned(c, DUET_OBJECT_POSES, &ids, &n, err)) ||
            !duet_cluster_step(c, &r, err))
            return false;
        if (i < 0)
            printf("first step %.1f s\n", seconds_now() - begun);
        else
            ms[i] = r.total_ms;
    }
    qsort(ms, (size_t)steps, sizeof *ms, ascending);
    printf("%llu objects, %llu pairs, hash %016llx\n", (unsigned long long)r.objects,
           (unsigned long long)r.pairs, (unsigned long long)r.hash);
    printf("step %.1f ms, median of %d, %.1f to %.1f; %.1f GB at most\n", ms[(steps - 1) / 2],
           steps, ms[0], ms[steps - 1], rss_gb());
    return true;
}

int main(int argc, char **argv)
{
    duet_error err = {0};
    duet_cluster_def def = duet_default_cluster_def();
    uint64_t n = argc > 2 ? strtoull(argv[1], NULL, 10) : 0;
    int steps = argc > 3 ? atoi(argv[3]) : 5;
    if (n == 0 || n > DUET_MOST_OBJECTS || steps < 1 || steps > MOST_STEPS) {
        fprintf(stderr, "usage: duet_bench_cluster OBJECTS PARTS [STEPS [PAIR]]\n");
        return 2;
    }
    def.parts = (uint32_t)strtoul(argv[2], NULL, 10);
    def.pair = argc > 4 ? argv[4] : NULL;
    def.drops_pairs = true;
    duet_cluster *c = duet_cluster_create(&def, &err);
    double begun = seconds_now();
    bool ok = c && give_objects(c, n, (float)cbrt(8.0 * (double)n), &err);
    if (ok)
        printf("objects %.1f s\n", seconds_now() - begun);
    ok = ok && run(c, steps, &err);
    duet_cluster_destroy(c);
    if (!ok)
        fprintf(stderr, "duet_bench_cluster: %s\n", err.text);
    return !ok;
}
