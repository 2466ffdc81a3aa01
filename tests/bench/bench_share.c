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

// What the better one of the devices takes alone.
static double alone(const subject subjects[N], double (*value)(const subject *))
{
    return fmin(value(&subjects[ALONE_A]), value(&subjects[ALONE_B]));
}

static double search_median(const subject *s)
{
    return series_median(&s->searching);
}

static double step_median(const subject *s)
{
    return series_median(&s->total);
}

static double step_least(const subject *s)
{
    return series_least(&s->total);
}

static void print(const subject subjects[N])
{
    static const struct {
        const char *name;
        double (*value)(const subject *);
    } columns[] = {{"search", search_median}, {"step", step_median}, {"least step", step_least}};
    enum { N_COLUMNS = sizeof columns / sizeof columns[0] };
    printf("%u objects\n%-20s", subjects[0].def.n, "ms");
    for (int c = 0; c < N_COLUMNS; ++c)
        printf(" %10s %8s", columns[c].name, "to alone");
    printf(" %10s\n", "CPU time");
    for (int i = 0; i < N; ++i) {
        printf("%-20s", splits[i].name);
        for (int c = 0; c < N_COLUMNS; ++c) {
            double ms = columns[c].value(&subjects[i]);
            printf(" %10.2f %8.2f", ms, ms / alone(subjects, columns[c].value));
        }
        printf(" %10.2f\n", series_median(&subjects[i].cpu));
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
