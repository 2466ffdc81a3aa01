// SPDX-License-Identifier: MIT
// What an application's start pays for its profile: opening the store and
// looking up, with --n profiles in it, and telling what kind of world it has.
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "paper_scene.h"

#include "profiles/lookup.h"
#include "runtime/base/clock.h"
#include "runtime/base/error.h"
#include "runtime/base/rng.h"
#include "runtime/profiled.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char kernels[] = "of the benchmark";

static profile_pair invent_pair(void)
{
    profile_env cpu = {.device = {.kind = "cpu", .vendor = "v", .name = "CPU", .units = 16},
                       .platform = "p",
                       .platform_version = "1",
                       .driver = "1",
                       .cl_version = "1.2"};
    profile_env gpu = cpu;
    gpu.device.kind = "gpu";
    gpu.device.name = "GPU";
    return (profile_pair){cpu, gpu};
}

static profile_workload invent_workload(uint64_t n)
{
    return (profile_workload){.dims = 3,
                              .n = n,
                              .cells = {100, 100, 100},
                              .cell = 1,
                              .occ_mean = 1,
                              .occ_p99 = 4,
                              .size_ratio = 1,
                              .shape = "poses",
                              .level = "certified"};
}

static bool fill(store *s, uint32_t n, duet_error *err)
{
    profile_pair pair = invent_pair();
    profile_row row = {.kernels = kernels,
                       .objective = "time",
                       .plan = {.mode = "own", .level = "certified"},
                       .verdict = "same",
                       .origin = "manual",
                       .trial_number = -1};
    if (!store_begin(s, err))
        return false;
    bool ok = profile_pair_put(s, &pair, &row.pair_id, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
        profile_workload workload = invent_workload(1000 + i);
        ok = profile_workload_put(s, &workload, &row.workload_id, err) &&
             profile_put(s, &row, "filled again", err);
    }
    return store_end(s, ok, err);
}

// What is asked for, and where the ladder is to end.
typedef struct question {
    uint64_t n;
    bool any_level; // within an accuracy
    profile_grade grade;
} question;

// One look-up for a workload that is there, or for one that no rung knows.
static bool measure(const char *path, question ask, series *us, duet_error *err)
{
    static const char *const levels[] = {"certified", "aabb", "sphere", "sat6", "sat15", "double"};
    profile_pair pair = invent_pair();
    profile_workload workload = invent_workload(ask.n);
    profile_found found;
    uint64_t start = clock_steady_ns();
    profile_request request = profile_default_request();
    request.pair = &pair;
    request.workload = &workload;
    request.kernels = kernels;
    if (ask.any_level) {
        request.levels = levels;
        request.n_levels = sizeof levels / sizeof *levels;
        request.max_missed_rate = request.max_false_rate = 0;
    }
    bool ok = profile_lookup_files(path, NULL, &request, &found, NULL, err);
    series_add(us, (double)(clock_steady_ns() - start) * 1e-3);
    return ok && (found.grade == ask.grade ||
                  error_set(err, DUET_WRONG_RESULT, "grade %s, not %s",
                            profile_grade_name(found.grade), profile_grade_name(ask.grade)));
}

static bool measure_all(const char *path, uint32_t n, const bench_options *options, duet_error *err)
{
    rng r = rng_seed(options->seed);
    series hits = {0};
    series within = {0};
    series misses = {0};
    bool ok = true;
    for (uint32_t i = 0; ok && i < 10 * options->runs; ++i) {
        uint64_t there = 1000 + rng_below(&r, n);
        ok = measure(path, (question){there, false, PROFILE_EXACT}, &hits, err) &&
             measure(path, (question){there, true, PROFILE_EXACT}, &within, err) &&
             measure(path, (question){1, false, PROFILE_DEFAULT}, &misses, err);
    }
    if (ok)
        printf("%u profiles, open and look up, medians of %u: found %.0f us (least %.0f), "
               "within an accuracy %.0f us (least %.0f), default %.0f us (least %.0f)\n",
               n, hits.n, series_median(&hits), series_least(&hits), series_median(&within),
               series_least(&within), series_median(&misses), series_least(&misses));
    return ok;
}

static bool describe(duet_world *world, const duet_pose *poses, uint32_t n,
                     const bench_options *options, duet_error *err)
{
    series us = {0};
    bool ok = duet_world_set_poses(world, poses, n, err);
    for (uint32_t i = 0; ok && i < options->runs; ++i) {
        profiled p;
        uint64_t start = clock_steady_ns();
        ok = profiled_world(world, &p, err);
        series_add(&us, (double)(clock_steady_ns() - start) * 1e-3);
    }
    if (ok)
        printf("what kind of world %u boxes are, median of %u: %.0f us (least %.0f)\n", n, us.n,
               series_median(&us), series_least(&us));
    return ok;
}

static bool describe_worlds(const bench_options *options, duet_error *err)
{
    static const uint32_t numbers[] = {20000, 250000, 1000000};
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_open(&pair_def, err);
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    duet_world *world = pair ? duet_world_create(&def, err) : NULL;
    bool ok = world;
    for (size_t i = 0; ok && i < sizeof numbers / sizeof *numbers; ++i) {
        duet_pose *poses = paper_poses(numbers[i], options->seed);
        ok = poses ? describe(world, poses, numbers[i], options, err)
                   : error_set(err, DUET_NO_MEMORY, "%u boxes: no memory", numbers[i]);
        free(poses);
    }
    duet_world_destroy(world);
    duet_device_pair_close(pair);
    return ok;
}

bool bench_lookup(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 10000;
    char folder[] = "bench_lookup.XXXXXX";
    char path[64];
    if (!mkdtemp(folder))
        return error_set(err, DUET_IO_FAILED, "%s: cannot be made here", folder);
    snprintf(path, sizeof path, "%s/profiles.db", folder);
    store *s = store_open(path, STORE_WRITE, err);
    bool ok = s && fill(s, n, err);
    store_close(s);
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL); // until the file counts as settled
    ok = ok && measure_all(path, n, options, err) && describe_worlds(options, err);
    unlink(path);
    rmdir(folder);
    return ok;
}
