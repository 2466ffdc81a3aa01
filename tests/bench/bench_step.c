// SPDX-License-Identifier: MIT
// A whole step on all cores of one CPU, against the AVX2 program, rows one at a time and the
// paper's own kernels, each in turn and by its stages.
#include "bench.h"

#include "subject.h"
#ifdef BENCH_AVX2
#include "limit_avx2.h"
#endif

enum { LANES, LISTED, ROWS, PAPER, N };

static const char *const variants[N] = {"simd", "auto", "gpu", "paper"};

// ---------------------------------------------------------------- the AVX2 program

#ifdef BENCH_AVX2

enum { THREADS = 2 };

static const struct {
    const char *name;
    size_t offset;
} stages[] = {
    {"count", offsetof(limit_times, count)},           {"scan", offsetof(limit_times, scan)},
    {"place", offsetof(limit_times, place)},           {"reorder", offsetof(limit_times, reorder)},
    {"candidates", offsetof(limit_times, candidates)}, {"narrow", offsetof(limit_times, narrow)},
};

enum { N_STAGES = sizeof stages / sizeof *stages };

typedef struct limit_side {
    limit *limit;
    series total, cpu, stages[N_STAGES];
} limit_side;

static void limit_side_open(limit_side *avx2, uint32_t n)
{
    must((__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) ||
         error_set(ERR, DUET_STATUS_NOT_FOUND, "this processor has no AVX2 and FMA"));
    avx2->limit = limit_open(n, paper_world(n), PAPER_CELL, THREADS);
    must(avx2->limit || error_set(ERR, DUET_STATUS_NO_MEMORY, "no memory for %u objects", n));
}

static void limit_side_step(limit_side *avx2, const duet_pose *poses)
{
    limit_times times;
    must(limit_run(avx2->limit, poses, &times) ||
         error_set(ERR, DUET_STATUS_TOO_MANY, "more pairs than the AVX2 program has space for"));
    series_add(&avx2->total, times.total);
    series_add(&avx2->cpu, times.processors * times.total);
    for (int i = 0; i < N_STAGES; ++i)
        series_add(&avx2->stages[i], *(double *)((char *)&times + stages[i].offset));
}

static void limit_side_print(const limit_side *avx2, const subject *lanes)
{
    subject_print_times("AVX2 program", &avx2->total, &avx2->cpu);
    for (int i = 0; i < N_STAGES; ++i)
        subject_print_stage(stages[i].name, &avx2->stages[i]);
    printf("simd takes %.2f of the AVX2 program's time (CPU time: %.2f); wanted: 1.6\n",
           series_median(&lanes->total) / series_median(&avx2->total),
           series_median(&lanes->cpu) / series_median(&avx2->cpu));
}

static void limit_side_verify(const limit_side *avx2, const duet_pose *poses, uint32_t n)
{
    duet_span spans[THREADS];
    for (uint32_t t = 0; t < THREADS; ++t)
        spans[t] = limit_span(avx2->limit, t);
    bench_verify(poses, n, spans, THREADS);
}

#else // there is none

typedef int limit_side;
#define limit_side_open(avx2, n) ((void)(avx2))
#define limit_side_step(avx2, poses) ((void)(avx2))
#define limit_side_print(avx2, lanes) ((void)(avx2))
#define limit_side_verify(avx2, poses, n) ((void)(avx2))

#endif

// ---------------------------------------------------------------- all

static double candidates_ms(const subject *s)
{
    return series_median(subject_stage(s, "candidates"));
}

static void print(const limit_side *avx2, subject *const subjects[N])
{
    const subject *lanes = subjects[LANES], *paper = subjects[PAPER];
    printf("%u objects, bounds to confirmed pairs in host memory\n", lanes->def.n);
    subject_print_head();
    for (int i = 0; i < N; ++i) {
        subject_print(subjects[i]);
        subject_print_stages(subjects[i]);
    }
    limit_side_print(avx2, lanes);
    printf("simd is %.1f times as fast as paper (CPU time: %.1f); wanted: 30\n",
           series_median(&paper->total) / series_median(&lanes->total),
           series_median(&paper->cpu) / series_median(&lanes->cpu));
    printf("the paper's candidates take %.1f times as long as merged rows eight at a time, %.1f as "
           "one at a time; wanted: 10\n",
           candidates_ms(paper) / candidates_ms(subjects[LISTED]),
           candidates_ms(paper) / candidates_ms(subjects[ROWS]));
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
    if (options->verify) {
        bench_verify(poses, n, subjects[LANES]->last.spans, 2);
        limit_side_verify(&avx2, poses, n);
    }
}
