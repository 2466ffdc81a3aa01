// SPDX-License-Identifier: MIT
// A whole step on all cores of one CPU, against the AVX2 program and the
// paper's own kernels, each in turn.
#include "bench.h"

#include "base/error.h"
#include "subject.h"
#ifdef BENCH_AVX2
#include "limit_avx2.h"
#endif

#include <stdio.h>
#include <stdlib.h>

enum { LANES, ROWS, PAPER, N };

static const char *const variants[N] = {"simd", "auto", "paper"};

// The AVX2 program as one more side; without AVX2 there is none.
typedef struct limit_side {
#ifdef BENCH_AVX2
    limit *limit;
#endif
    series total;
    series cpu;
} limit_side;

#ifdef BENCH_AVX2

static bool limit_side_open(limit_side *side, uint32_t n, duet_error *err)
{
    enum { THREADS = 2 };
    side->limit = limit_open(n, paper_world(n), PAPER_CELL, THREADS);
    return side->limit || error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u objects", n);
}

static bool limit_side_step(limit_side *side, const duet_pose *poses, duet_error *err)
{
    limit_times times;
    if (!limit_run(side->limit, poses, &times))
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "more pairs than the AVX2 program has space for");
    series_add(&side->total, times.total);
    series_add(&side->cpu, times.processors * times.total);
    return true;
}

static void limit_side_close(limit_side *side)
{
    limit_close(side->limit);
}

#else

static bool limit_side_open(limit_side *side, uint32_t n, duet_error *err)
{
    (void)side, (void)n, (void)err;
    return true;
}

static bool limit_side_step(limit_side *side, const duet_pose *poses, duet_error *err)
{
    (void)side, (void)poses, (void)err;
    return true;
}

static void limit_side_close(limit_side *side)
{
    (void)side;
}

#endif

static void print(const limit_side *side, const subject subjects[N])
{
    double lanes = series_median(&subjects[LANES].total);
    double lanes_cpu = series_median(&subjects[LANES].cpu);
    printf("%u objects, bounds to confirmed pairs in host memory\n", subjects[0].def.n);
    subject_print_head();
    if (side->total.n)
        subject_print_times("AVX2 program", &side->total, &side->cpu);
    for (int i = 0; i < N; ++i) {
        subject_print(&subjects[i]);
        subject_print_stages(&subjects[i]);
    }
    if (side->total.n)
        printf("simd takes %.2f of the AVX2 program's time (CPU time: %.2f); wanted: 1.6\n",
               lanes / series_median(&side->total), lanes_cpu / series_median(&side->cpu));
    printf("simd is %.1f times as fast as paper (CPU time: %.1f); wanted: 30\n",
           series_median(&subjects[PAPER].total) / lanes,
           series_median(&subjects[PAPER].cpu) / lanes_cpu);
}

bool bench_step(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    subject *subjects = calloc(N, sizeof *subjects);
    limit_side side = {0};
    bool ok = poses && subjects && limit_side_open(&side, n, err);
    for (int i = 0; ok && i < N; ++i) {
        subject_def def = {.name = variants[i],
                           .device_a = options->device,
                           .device_b = options->device,
                           .variant = variants[i],
                           .mode = DUET_MODE_OWN,
                           .poses = poses,
                           .n = n};
        ok = subject_open(&subjects[i], &def, err);
    }
    for (uint32_t run = 0; ok && run < options->runs; ++run)
        ok = limit_side_step(&side, poses, err) && subjects_step(subjects, N, 1, err);
    if (ok)
        print(&side, subjects);
    if (ok && options->verify)
        ok = bench_verify(poses, n, subjects[LANES].last.spans, 2, err);
    limit_side_close(&side);
    for (int i = 0; subjects && i < N; ++i)
        subject_close(&subjects[i]);
    free(subjects);
    free(poses);
    return ok;
}
