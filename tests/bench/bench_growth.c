// SPDX-License-Identifier: MIT
// Time an object from a quarter of a million objects to eight million, at the
// same density.
#include "bench.h"

#include "subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static bool measure(uint32_t n, const bench_options *options, double *ns, duet_error *err)
{
    duet_pose *poses = bench_poses(n, options, err);
    subject *s = calloc(1, sizeof *s);
    subject_def def = {.name = "lanes",
                       .device_a = options->device,
                       .device_b = options->device,
                       .variant = "lanes",
                       .mode = DUET_MODE_OWN,
                       .poses = poses,
                       .n = n};
    bool ok = poses && s && subject_open(s, &def, err) && subjects_step(s, 1, options->runs, err);
    if (ok) {
        *ns = series_median(&s->total) * 1e6 / n;
        printf("%9u %9.2f %9.2f %10.1f %10.2f\n", n, series_median(&s->total),
               series_least(&s->total), *ns, series_median(&s->processors));
        fflush(stdout);
    }
    if (s)
        subject_close(s);
    free(s);
    free(poses);
    return ok;
}

bool bench_growth(const bench_options *options, duet_error *err)
{
    uint32_t most = options->n ? options->n : 8000000;
    double best = INFINITY, worst = 0.0;
    printf("%9s %9s %9s %10s %10s\n", "objects", "median ms", "least", "ns/object", "processors");
    for (uint32_t n = 250000; n <= most; n *= 2) {
        double ns = 0.0;
        if (!measure(n, options, &ns, err))
            return false;
        best = fmin(best, ns);
        worst = fmax(worst, ns);
    }
    printf("the worst takes %.2f of the best's time an object; wanted: 1.4\n", worst / best);
    return true;
}
