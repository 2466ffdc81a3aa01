// SPDX-License-Identifier: MIT
// duet_bench NAME [--n N] [--runs K] [--seed S] [--pair A,B] [--task T] [--strategy S]
// [--seconds S]
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <time.h>
#include <unistd.h>

static const struct {
    const char *name;
    void (*run)(const bench_options *options);
    const char *about;
} benches[] = {
#define ROW(name, about) {#name, bench_##name, about},
    BENCHES(ROW)};

enum { N_BENCHES = sizeof benches / sizeof benches[0] };

duet_error bench_error;
static const char *running; // the benchmark's name

void bench_fail(void)
{
    fprintf(stderr, "duet_bench %s: %s\n", running, bench_error.text);
    exit(1);
}

void *bench_alloc(size_t bytes)
{
    void *zeros = calloc(1, bytes + 1);
    must(zeros || no_memory(ERR, "%zu bytes", bytes));
    return zeros;
}

double bench_cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

duet_device_pair *bench_pair(const bench_options *options)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    if (options->device_a) {
        def.a = options->device_a;
        def.b = options->device_b;
    }
    return must(duet_device_pair_create(&def, ERR));
}

duet_pose *bench_poses(uint32_t n, const bench_options *options)
{
    enum { PAGE = 4096 };
    size_t bytes = ((size_t)n * sizeof(duet_pose) + PAGE) / PAGE * PAGE;
    duet_pose *poses = aligned_alloc(PAGE, bytes);
    rng r = rng_seed(options->seed);
    float world = (float)cbrt(8.0 * n);
    must(poses || no_memory(ERR, "%u objects", n));
    for (uint32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            poses[i].centre[k] = (float)rng_between(&r, 0, world);
            poses[i].half_extents[k] = 0.5f;
        }
        for (int k = 0; k < 4; ++k)
            poses[i].rotation[k] = (float)rng_normal(&r);
    }
    return poses;
}

duet_world *bench_world(duet_device_pair *pair, duet_world_def def)
{
    def.pair = pair;
    return must(duet_world_create(&def, ERR));
}

bench_folder bench_make_folder(void)
{
    bench_folder f = {.path = "duet_bench.XXXXXX"};
    must(mkdtemp(f.path) ||
         error_set(ERR, DUET_STATUS_IO_FAILED, "%s: cannot be made here", f.path));
    for (int i = 0; i < 2; ++i)
        snprintf(f.stores[i], sizeof f.stores[i], "%s/%d.db", f.path, i);
    return f;
}

void bench_remove_folder(const bench_folder *folder)
{
    for (int i = 0; i < 2; ++i)
        unlink(folder->stores[i]);
    rmdir(folder->path);
}

static void run_side(bench_side *s, bool counts)
{
    if (s->begin)
        s->begin(s->of);
    uint64_t begun = clock_steady_ns();
    double cpu = bench_cpu_ms();
    s->run(s->of);
    if (!counts)
        return;
    series_add(&s->cpu, bench_cpu_ms() - cpu);
    series_add(&s->ms, (double)(clock_steady_ns() - begun) * 1e-6);
}

void bench_sides_run(bench_side *sides, uint32_t n, uint32_t runs)
{
    for (uint32_t run = 0; run <= runs; ++run)
        for (uint32_t i = 0; i < n; ++i)
            run_side(&sides[i], run > 0);
}

static int usage(void)
{
    fprintf(stderr, "usage: duet_bench NAME [--n N] [--runs K] [--seed S] [--pair A,B] "
                    "[--task T] [--strategy S] [--seconds S]\n");
    for (int i = 0; i < N_BENCHES; ++i)
        fprintf(stderr, "  %-10s %s\n", benches[i].name, benches[i].about);
    return 2;
}

// A whole number of at least `least`; false for anything else.
static bool read_number(const char *text, uint64_t least, uint64_t most, uint64_t *number)
{
    char *end = NULL;
    *number = text ? strtoull(text, &end, 10) : 0;
    return text && *text >= '0' && *text <= '9' && !*end && *number >= least && *number <= most;
}

static bool read_pair(char *text, bench_options *options)
{
    char *comma = text ? strchr(text, ',') : NULL;
    if (!comma)
        return false;
    *comma = '\0';
    options->device_a = text;
    options->device_b = comma + 1;
    return true;
}

// --name and its value; false where either is wrong.
static bool read_option(const char *name, char *value, bench_options *options)
{
    uint64_t number = 0;
    if (strcmp(name, "--pair") == 0)
        return read_pair(value, options);
    if (strcmp(name, "--task") == 0) {
        options->task = value;
        return value != NULL;
    }
    if (strcmp(name, "--strategy") == 0) {
        options->strategy = value;
        return value != NULL;
    }
    if (strcmp(name, "--seed") == 0)
        return read_number(value, 0, UINT64_MAX, &options->seed);
    if (strcmp(name, "--n") == 0 && read_number(value, 1, 1u << 26, &number)) {
        options->n = (uint32_t)number;
        return true;
    }
    if (strcmp(name, "--seconds") == 0 && read_number(value, 1, 1u << 20, &number)) {
        options->seconds = (double)number;
        return true;
    }
    if (strcmp(name, "--runs") == 0 && read_number(value, 1, SERIES_ROOM, &number)) {
        options->runs = (uint32_t)number;
        return true;
    }
    return false;
}

static bool read_options(char **words, bench_options *options)
{
    while (*words && read_option(words[0], words[1], options))
        words += 2;
    return !*words;
}

int main(int argc, char **argv)
{
    bench_options options = {.runs = 21, .seed = 1};
    if (argc < 2 || !read_options(argv + 2, &options))
        return usage();
    for (int i = 0; i < N_BENCHES; ++i) {
        if (strcmp(argv[1], benches[i].name) != 0)
            continue;
        running = benches[i].name;
        benches[i].run(&options);
        return 0;
    }
    return usage();
}
