// SPDX-License-Identifier: MIT
// Two devices against the better one of them, each way to split the work: the
// search alone (the paper shares no more than that) and the whole step.
#include "bench.h"

#include "subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ALONE_A, ALONE_B, OWN, SHARED, SLAB, N };

static const struct {
    const char *name;
    duet_mode mode;
    uint32_t share;
} splits[N] = {
    [ALONE_A] = {"A alone", DUET_MODE_OWN, DUET_SHARE_ONE},
    [ALONE_B] = {"B alone", DUET_MODE_OWN, 0},
    [OWN] = {"own, share 0.5", DUET_MODE_OWN, DUET_SHARE_ONE / 2},
    [SHARED] = {"shared, share 0.5", DUET_MODE_SHARED, DUET_SHARE_ONE / 2},
    [SLAB] = {"slab, share 0.5", DUET_MODE_SLAB, DUET_SHARE_ONE / 2},
};

static void print(const subject subjects[N])
{
    double search_alone = fmin(series_median(&subjects[ALONE_A].searching),
                               series_median(&subjects[ALONE_B].searching));
    double step_alone =
        fmin(series_median(&subjects[ALONE_A].total), series_median(&subjects[ALONE_B].total));
    printf("%u objects\n%-24s %9s %9s %9s %9s %9s\n", subjects[0].def.n, "ms", "search", "to alone",
           "step", "to alone", "CPU time");
    for (int i = 0; i < N; ++i) {
        double search = series_median(&subjects[i].searching);
        double step = series_median(&subjects[i].total);
        printf("%-24s %9.2f %9.2f %9.2f %9.2f %9.2f\n", splits[i].name, search,
               search / search_alone, step, step / step_alone, series_median(&subjects[i].cpu));
    }
    printf("wanted: search at most 0.62 of the better device alone; slab's step 0.58\n");
}

bool bench_share(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 500000;
    duet_pose *poses = bench_poses(n, options, err);
    subject *subjects = calloc(N, sizeof *subjects);
    bool ok = poses && subjects;
    for (int i = 0; ok && i < N; ++i) {
        subject_def def = {.name = splits[i].name,
                           .device_a = options->device_a,
                           .device_b = options->device_b,
                           .variant = "lanes",
                           .mode = splits[i].mode,
                           .share = splits[i].share,
                           .poses = poses,
                           .n = n};
        ok = subject_open(&subjects[i], &def, err);
    }
    ok = ok && subjects_step(subjects, N, options->runs, err);
    if (ok)
        print(subjects);
    for (int i = 0; subjects && i < N; ++i)
        subject_close(&subjects[i]);
    free(subjects);
    free(poses);
    return ok;
}
