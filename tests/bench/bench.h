// SPDX-License-Identifier: MIT
// What the benchmarks share.
//
// A ratio is taken of medians over runs that alternate: what disturbs one side
// disturbs the other too. CPU time stands beside it, for a figure of two threads
// that shared one processor says nothing of two.
//
// A call that fails ends the program with a line. What a benchmark makes lasts as long as the
// program.
#ifndef BENCH_BENCH_H
#define BENCH_BENCH_H

#include "base/clock.h"
#include "base/error.h"
#include "base/rng.h"
#include "runtime/duet.h"
#include "series.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench_options {
    const char *device_a; // selectors of two; NULL: the default device pair
    const char *device_b;
    const char *task;     // one of the example tasks; NULL: all
    const char *strategy; // for tasks, beside every plan and the default; NULL: all
    uint32_t n;           // objects; 0: the benchmark's own number
    uint32_t runs;        // runs of each side
    double seconds;       // the most that brute force may take; 0: any
    uint64_t seed;
} bench_options;

// X(name, what it compares) for each benchmark.
// clang-format off
#define BENCHES(X)                                                                               \
    X(commands, "bodies that come and go before each step, and the same only woken")             \
    X(cost, "processor time and instructions of a step of six scenes, for .ci/cost")             \
    X(generate, "the text of each kernel, and its number of configs")                            \
    X(lookup, "opening the profile store and looking up, with --n profiles in it")               \
    X(loss, "plans that are looked up beside fresh tunings, at --runs sizes around --n")         \
    X(join, "a hundredth of the paper's scene against all of it, and a step of both")            \
    X(order, "objects at random and in order, on one device and two")                            \
    X(rays, "a tree over the paper's scene, and as many rays through it")                        \
    X(spheres, "a million equal spheres, and as many unrotated cubes in their places")           \
    X(pairs, "searches for kernels and share on invented device pairs")                         \
    X(tasks, "kernels and share of the example tasks, by each strategy and by all plans")        \
    X(strategies, "searches for the share on invented device pairs")
#define BENCH_DECLARE(name, about) void bench_##name(const bench_options *options);
BENCHES(BENCH_DECLARE)
// clang-format on

// The value of a call that must succeed, in which ERR stands for the error that it fills.
#define must(call)                        \
    __extension__({                       \
        __typeof__(call) given_ = (call); \
        if (!given_)                      \
            bench_fail();                 \
        given_;                           \
    })
#define ERR (&bench_error)

extern duet_error bench_error;
_Noreturn void bench_fail(void); // ends the program with that error's line

void *bench_alloc(size_t bytes); // zeros
double bench_cpu_ms(void);       // processor time of all threads

// The device pair that was asked for, else the default one.
duet_device_pair *bench_pair(const bench_options *options);

// The scene of the paper's measurements: n unit cubes with random centres and rotations in a cube
// that holds one for every eight units of its volume. Given back by free.
duet_pose *bench_poses(uint32_t n, const bench_options *options);

// A world with the plan of its def on that pair.
duet_world *bench_world(duet_device_pair *pair, duet_world_def def);

// A folder below the one one is in, and paths of files in it, which go with it.
typedef struct bench_folder {
    char path[32];
    char stores[2][48];
} bench_folder;

bench_folder bench_make_folder(void);
void bench_remove_folder(const bench_folder *folder);

// A thing that is run in turn with others, and how long it took.
typedef struct bench_side {
    const char *name;
    void (*begin)(void *of); // not timed; may be NULL
    void (*run)(void *of);
    void *of;
    series ms, cpu;
} bench_side;

// Runs each side so many times, and once before, when kernels are compiled, which does not count.
void bench_sides_run(bench_side *sides, uint32_t n, uint32_t runs);

#endif
