// SPDX-License-Identifier: MIT
// Candidates in merged rows, eight and one at a time, against the paper's
// kernel, on one device.
#include "subject.h"

void bench_candidates(const bench_options *options)
{
    enum { LANES, ROWS, PAPER, N };
    static const char *const variants[N] = {"auto", "gpu", "paper"};
    uint32_t n = options->n ? options->n : 1000000;
    const duet_pose *poses = bench_poses(n, options);
    subject *subjects[N];
    double ms[N];
    for (int i = 0; i < N; ++i)
        subjects[i] = subject_alone(options, variants[i], poses, n);
    subjects_step(subjects, N, options->runs);
    printf("%u objects, the candidates' kernel alone\n", n);
    printf("%-24s %9s %9s\n", "ms", "median", "least");
    for (int i = 0; i < N; ++i) {
        const series *stage = subject_stage(subjects[i], "candidates");
        ms[i] = series_median(stage);
        printf("%-24s %9.2f %9.2f\n", variants[i], ms[i], series_least(stage));
    }
    printf("merged rows are %.1f times as fast eight at a time, %.1f one at a time; wanted: 10\n",
           ms[PAPER] / ms[LANES], ms[PAPER] / ms[ROWS]);
}
