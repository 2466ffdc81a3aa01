// SPDX-License-Identifier: MIT
// The AVX2 program alone, stage by stage.
#include "bench.h"

#include "limit_avx2.h"

enum { THREADS = 2 };

static const struct {
    const char *name;
    size_t offset;
} rows[] = {
    {"count", offsetof(limit_times, count)},
    {"scan", offsetof(limit_times, scan)},
    {"place", offsetof(limit_times, place)},
    {"reorder", offsetof(limit_times, reorder)},
    {"candidates", offsetof(limit_times, candidates)},
    {"narrow", offsetof(limit_times, narrow)},
    {"total", offsetof(limit_times, total)},
    {"processors", offsetof(limit_times, processors)},
};

enum { N_ROWS = sizeof rows / sizeof rows[0] };

void bench_limit(const bench_options *options)
{
    must((__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) ||
         error_set(ERR, DUET_STATUS_NOT_FOUND, "this processor has no AVX2 and FMA"));
    uint32_t n = options->n ? options->n : 1000000;
    const duet_pose *poses = bench_poses(n, options);
    limit *l = limit_open(n, paper_world(n), PAPER_CELL, THREADS);
    series columns[N_ROWS] = {0};
    must(l || error_set(ERR, DUET_STATUS_NO_MEMORY, "no memory for %u objects", n));
    for (uint32_t run = 0; run < options->runs; ++run) {
        limit_times times;
        must(limit_run(l, poses, &times) ||
             error_set(ERR, DUET_STATUS_TOO_MANY, "more pairs than the program has space for"));
        for (int i = 0; i < N_ROWS; ++i)
            series_add(&columns[i], *(const double *)((const char *)&times + rows[i].offset));
    }
    printf("%u objects, %u runs: median and least, ms\n", n, options->runs);
    for (int i = 0; i < N_ROWS; ++i)
        printf("%-12s %8.2f %8.2f\n", rows[i].name, series_median(&columns[i]),
               series_least(&columns[i]));
    duet_span spans[THREADS];
    for (uint32_t t = 0; t < THREADS; ++t)
        spans[t] = limit_span(l, t);
    printf("%" PRIu64 " candidates, %" PRIu64 " pairs, %" PRIu64 " left open by float\n",
           limit_candidates(l), spans[0].n + spans[1].n, limit_open_pairs(l));
    if (options->verify)
        bench_verify(poses, n, spans, THREADS);
}
