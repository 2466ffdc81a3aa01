// SPDX-License-Identifier: MIT
// What an application's start pays for its profile: opening the store and
// looking up, with --n profiles in it, and telling what kind of world it has.
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include "profiles/lookup.h"

#include <time.h>

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

static void fill(const char *path, uint32_t n)
{
    store *s = must(store_open(path, STORE_WRITE, ERR));
    profile_pair pair = invent_pair();
    profile_row row = {.kernels = kernels,
                       .objective = "time",
                       .plan = {.mode = "own", .level = "certified"},
                       .verdict = "same",
                       .origin = "manual",
                       .trial_number = -1};
    must(store_begin(s, ERR));
    must(profile_pair_put(s, &pair, &row.pair_id, ERR));
    for (uint32_t i = 0; i < n; ++i) {
        profile_workload workload = invent_workload(1000 + i);
        must(profile_workload_put(s, &workload, &row.workload_id, ERR));
        must(profile_put(s, &row, NULL, "filled again", NULL, ERR));
    }
    must(store_end(s, true, ERR));
    store_close(s);
}

// The question, and where the ladder is to end.
typedef struct question {
    uint64_t n;
    bool any_level; // within an accuracy
    profile_grade grade;
} question;

// One look-up for a workload that is there, or for one that no rung knows.
static void measure(const char *path, question ask, series *us)
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
    must(profile_lookup_files(path, NULL, &request, &found, NULL, ERR));
    series_add(us, (double)(clock_steady_ns() - start) * 1e-3);
    must(found.grade == ask.grade ||
         error_set(ERR, DUET_STATUS_WRONG_RESULT, "grade %s, not %s",
                   profile_grade_name(found.grade), profile_grade_name(ask.grade)));
}

static void measure_all(const char *path, uint32_t n, const bench_options *options)
{
    rng r = rng_seed(options->seed);
    series hits = {0};
    series within = {0};
    series misses = {0};
    for (uint32_t i = 0; i < 10 * options->runs; ++i) {
        uint64_t there = 1000 + rng_below(&r, n);
        measure(path, (question){there, false, PROFILE_EXACT}, &hits);
        measure(path, (question){there, true, PROFILE_EXACT}, &within);
        measure(path, (question){1, false, PROFILE_DEFAULT}, &misses);
    }
    printf("%u profiles, open and look up, medians of %u: found %.0f us (least %.0f), "
           "within an accuracy %.0f us (least %.0f), default %.0f us (least %.0f)\n",
           n, hits.n, series_median(&hits), series_least(&hits), series_median(&within),
           series_least(&within), series_median(&misses), series_least(&misses));
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

static void load(duet_world *world, const char *path, series *us)
{
    duet_profile profile;
    uint64_t begun = clock_steady_ns();
    must(duet_world_load_profile(world, path, &profile, ERR));
    series_add(us, us_since(begun));
}

static void start_once(duet_device_pair *pair, const char *path, const duet_pose *poses, uint32_t n,
                       start *s)
{
    duet_world *world = bench_world(pair, duet_default_world_def());
    uint64_t begun = clock_steady_ns();
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, ERR));
    series_add(&s->set, us_since(begun));
    load(world, path, &s->load);
    must(duet_world_map_objects(world, DUET_OBJECT_POSES, n, ERR));
    load(world, path, &s->load_again);
    duet_world_destroy(world);
}

static void start_with(duet_device_pair *pair, const char *path, uint32_t n,
                       const bench_options *options)
{
    const duet_pose *poses = bench_poses(n, options);
    start s = {0};
    for (uint32_t i = 0; i < options->runs; ++i)
        start_once(pair, path, poses, n, &s);
    printf("%7u boxes, medians of %u: first set %.0f us (least %.0f), load %.0f us (least "
           "%.0f), written again and load %.0f us (least %.0f)\n",
           n, s.set.n, series_median(&s.set), series_least(&s.set), series_median(&s.load),
           series_least(&s.load), series_median(&s.load_again), series_least(&s.load_again));
}

void bench_lookup(const bench_options *options)
{
    static const uint32_t numbers[] = {20000, 250000, 1000000};
    uint32_t n = options->n ? options->n : 10000;
    bench_folder folder = bench_make_folder();
    const char *path = folder.stores[0];
    fill(path, n);
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL); // until the file counts as settled
    measure_all(path, n, options);
    duet_device_pair *pair = must(duet_device_pair_open(NULL, ERR));
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        start_with(pair, path, numbers[i], options);
    bench_remove_folder(&folder);
}
