// SPDX-License-Identifier: MIT
// Candidates in merged rows, eight and one at a time, against the paper's
// kernel, on one device.
#include "bench.h"

#include "subject.h"

#include <stdio.h>
#include <stdlib.h>

bool bench_candidates(const bench_options *options, duet_error *err)
{
    enum { LANES, ROWS, PAPER, N };
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    subject subjects[N] = {0};
    bool ok = poses != NULL;
    static const char *const variants[N] = {"auto", "gpu", "paper"};
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
    ok = ok && subjects_step(subjects, N, options->runs, err);
    if (ok) {
        double ms[N];
        printf("%u objects, the candidates' kernel alone\n", n);
        printf("%-24s %9s %9s\n", "ms", "median", "least");
        for (int i = 0; i < N; ++i) {
            const series *stage = subject_stage(&subjects[i], "candidates");
            ms[i] = series_median(stage);
            printf("%-24s %9.2f %9.2f\n", variants[i], ms[i], series_least(stage));
        }
        printf(
            "merged rows are %.1f times as fast eight at a time, %.1f one at a time; wanted: 10\n",
            ms[PAPER] / ms[LANES], ms[PAPER] / ms[ROWS]);
    }
    for (int i = 0; i < N; ++i)
        subject_close(&subjects[i]);
    free(poses);
    return ok;
}
