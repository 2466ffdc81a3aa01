// SPDX-License-Identifier: MIT
// A whole step on all cores of one CPU, against rows one at a time and the paper's own kernels,
// each in turn and by its stages.
#include "bench.h"

#include "subject.h"

enum { LANES, LISTED, ROWS, PAPER, N };

static const char *const variants[N] = {"simd", "auto", "gpu", "paper"};

static double candidates_ms(const subject *s)
{
    return series_median(subject_stage(s, "candidates"));
}

static void print(subject *const subjects[N])
{
    const subject *lanes = subjects[LANES], *paper = subjects[PAPER];
    printf("%u objects, bounds to confirmed pairs in host memory\n", lanes->def.n);
    subject_print_head();
    for (int i = 0; i < N; ++i) {
        subject_print(subjects[i]);
        subject_print_stages(subjects[i]);
    }
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
    for (int i = 0; i < N; ++i)
        subjects[i] = subject_alone(options, variants[i], poses, n);
    subjects_step(subjects, N, options->runs);
    print(subjects);
    if (options->verify)
        bench_verify(poses, n, subjects[LANES]->last.spans, 2);
}
