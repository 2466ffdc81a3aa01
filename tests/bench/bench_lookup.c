// SPDX-License-Identifier: MIT
// What an application's start pays for its profile: opening the store and
// looking up, with --n profiles in it, and telling what kind of world it has.
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include "base/clock.h"
#include "base/rng.h"
#include "profiles/lookup.h"

#include <stdio.h>
#include <stdlib.h>
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
    return (profile_pair){.a = cpu, .b = gpu};
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
             profile_put(s, &row, NULL, "filled again", NULL, err);
    }
    return store_end(s, ok, err);
}

// The question, and where the ladder is to end.
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
                  error_set(err, DUET_STATUS_WRONG_RESULT, "grade %s, not %s",
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

// A start: the world's first objects, then their profile; and the profile of
// objects that were written again since.
typedef struct start {
    series set;
    series load;
    series load_again;
} start;

static double us_since(uint64_t begun)
{
    return (double)(clock_steady_ns() - begun) * 1e-3;
}

static bool load(duet_world *world, const char *path, series *us, duet_error *err)
{
    duet_profile profile;
    uint64_t begun = clock_steady_ns();
    bool ok = duet_world_load_profile(world, path, &profile, err);
    series_add(us, us_since(begun));
    return ok;
}

static bool start_once(duet_device_pair *pair, const char *path, const duet_pose *poses, uint32_t n,
                       start *s, duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    duet_world *world = duet_world_create(&def, err);
    uint64_t begun = clock_steady_ns();
    bool ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, err);
    series_add(&s->set, us_since(begun));
    ok = ok && load(world, path, &s->load, err) &&
         duet_world_map_objects(world, DUET_OBJECT_POSES, n, err) &&
         load(world, path, &s->load_again, err);
    duet_world_destroy(world);
    return ok;
}

static bool start_with(duet_device_pair *pair, const char *path, uint32_t n,
                       const bench_options *options, duet_error *err)
{
    duet_pose *poses = bench_poses(n, options, err);
    start s = {0};
    bool ok = poses;
    for (uint32_t i = 0; ok && i < options->runs; ++i)
        ok = start_once(pair, path, poses, n, &s, err);
    if (ok)
        printf("%7u boxes, medians of %u: first set %.0f us (least %.0f), load %.0f us (least "
               "%.0f), written again and load %.0f us (least %.0f)\n",
               n, s.set.n, series_median(&s.set), series_least(&s.set), series_median(&s.load),
               series_least(&s.load), series_median(&s.load_again), series_least(&s.load_again));
    free(poses);
    return ok;
}

static bool start_worlds(const char *path, const bench_options *options, duet_error *err)
{
    static const uint32_t numbers[] = {20000, 250000, 1000000};
    duet_device_pair_def def = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&def, err);
    bool ok = pair;
    for (size_t i = 0; ok && i < sizeof numbers / sizeof *numbers; ++i)
        ok = start_with(pair, path, numbers[i], options, err);
    duet_device_pair_destroy(pair);
    return ok;
}

bool bench_lookup(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 10000;
    char folder[] = "bench_lookup.XXXXXX";
    char path[64];
    if (!mkdtemp(folder))
        return error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be made here", folder);
    snprintf(path, sizeof path, "%s/profiles.db", folder);
    store *s = store_open(path, STORE_WRITE, err);
    bool ok = s && fill(s, n, err);
    store_close(s);
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL); // until the file counts as settled
    ok = ok && measure_all(path, n, options, err) && start_worlds(path, options, err);
    unlink(path);
    rmdir(folder);
    return ok;
}
