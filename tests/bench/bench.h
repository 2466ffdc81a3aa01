// SPDX-License-Identifier: MIT
// What the benchmarks share.
//
// A ratio is taken of medians over runs that alternate: what disturbs one side
// disturbs the other too. CPU time stands beside it, for a figure of two threads
// that shared one processor says nothing of two.
#ifndef BENCH_BENCH_H
#define BENCH_BENCH_H

#include "paper_scene.h"
#include "runtime/duet.h"
#include "series.h"

typedef struct bench_options {
    const char *device;   // selector of the one device
    const char *device_a; // selectors of two; NULL: the default device pair
    const char *device_b;
    const char *task;     // one of the example tasks; NULL: all
    const char *strategy; // for tasks, beside every plan and the default; NULL: all
    uint32_t n;           // objects; 0: the benchmark's own number
    uint32_t runs;        // runs of each side
    double seconds;       // the most that brute force may take; 0: any
    uint64_t seed;
    bool verify; // compare with the reference first
} bench_options;

// One benchmark: prints its figures, or fails with a line.
typedef bool bench_run(const bench_options *options, duet_error *err);

bench_run bench_candidates;
bench_run bench_cells;
bench_run bench_commands;
bench_run bench_cost;
bench_run bench_generate;
bench_run bench_growth;
bench_run bench_join;
bench_run bench_spheres;
bench_run bench_limit;
bench_run bench_lookup;
bench_run bench_loss;
bench_run bench_order;
bench_run bench_rays;
bench_run bench_share;
bench_run bench_step;
bench_run bench_still;
bench_run bench_strategies;
bench_run bench_tasks;
bench_run bench_tune;

// The device pair that was asked for, else the default one.
duet_device_pair *bench_pair(const bench_options *options, duet_error *err);

// The paper's scene with n objects; given back by free.
duet_pose *bench_poses(uint32_t n, const bench_options *options, duet_error *err);

// Whether spans hold exactly the pairs that the reference finds.
bool bench_verify(const duet_pose *poses, uint32_t n, const duet_span *spans, uint32_t n_spans,
                  duet_error *err);

#endif
