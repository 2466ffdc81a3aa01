// SPDX-License-Identifier: MIT
// A whole step on all cores of one CPU, against the AVX2 program and the
// paper's own kernels, each in turn.
#include "bench.h"

#include "subject.h"
#ifdef BENCH_AVX2
#include "limit_avx2.h"
#endif

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

static void limit_side_open(limit_side *avx2, uint32_t n)
{
#ifdef BENCH_AVX2
    enum { THREADS = 2 };
    avx2->limit = limit_open(n, paper_world(n), PAPER_CELL, THREADS);
    must(avx2->limit || error_set(ERR, DUET_STATUS_NO_MEMORY, "no memory for %u objects", n));
#else
    (void)avx2, (void)n;
#endif
}

static void limit_side_step(limit_side *avx2, const duet_pose *poses)
{
#ifdef BENCH_AVX2
    limit_times times;
    must(limit_run(avx2->limit, poses, &times) ||
         error_set(ERR, DUET_STATUS_TOO_MANY, "more pairs than the AVX2 program has space for"));
    series_add(&avx2->total, times.total);
    series_add(&avx2->cpu, times.processors * times.total);
#else
    (void)avx2, (void)poses;
#endif
}

static void print(const limit_side *avx2, subject *const subjects[N])
{
    double lanes = series_median(&subjects[LANES]->total);
    double lanes_cpu = series_median(&subjects[LANES]->cpu);
    printf("%u objects, bounds to confirmed pairs in host memory\n", subjects[0]->def.n);
    subject_print_head();
    if (avx2->total.n)
        subject_print_times("AVX2 program", &avx2->total, &avx2->cpu);
    for (int i = 0; i < N; ++i) {
        subject_print(subjects[i]);
        subject_print_stages(subjects[i]);
    }
    if (avx2->total.n)
        printf("simd takes %.2f of the AVX2 program's time (CPU time: %.2f); wanted: 1.6\n",
               lanes / series_median(&avx2->total), lanes_cpu / series_median(&avx2->cpu));
    printf("simd is %.1f times as fast as paper (CPU time: %.1f); wanted: 30\n",
           series_median(&subjects[PAPER]->total) / lanes,
           series_median(&subjects[PAPER]->cpu) / lanes_cpu);
}

void bench_step(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 1000000;
    const duet_pose *poses = bench_poses(n, options);
    subject *subjects[N];
    static limit_side avx2;
    limit_side_open(&avx2, n);
    for (int i = 0; i < N; ++i)
        subjects[i] = subject_alone(options, variants[i], poses, n);
    for (uint32_t run = 0; run < options->runs; ++run) {
        limit_side_step(&avx2, poses);
        subjects_step(subjects, N, 1);
    }
    print(&avx2, subjects);
    if (options->verify)
        bench_verify(poses, n, subjects[LANES]->last.spans, 2);
}
