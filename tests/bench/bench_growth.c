// SPDX-License-Identifier: MIT
// Time an object from a quarter of a million objects to eight million, at the
// same density.
#include "bench.h"

#include "subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// The time that a size took for an object.
typedef struct cost {
    double ns;
    double cpu_ns;
} cost;

static bool measure(uint32_t n, const bench_options *options, cost *c, duet_error *err)
{
    duet_pose *poses = bench_poses(n, options, err);
    subject *s = calloc(1, sizeof *s);
    subject_def def = {.name = "simd",
                       .device_a = options->device,
                       .device_b = options->device,
                       .variant = "simd",
                       .mode = DUET_MODE_OWN,
                       .poses = poses,
                       .n = n};
    bool ok = poses && s && subject_open(s, &def, err) && subjects_step(s, 1, options->runs, err);
    if (ok) {
        *c = (cost){series_median(&s->total) * 1e6 / n, series_median(&s->cpu) * 1e6 / n};
        printf("%9u %9.2f %9.2f %10.1f %10.1f\n", n, series_median(&s->total),
               series_least(&s->total), c->ns, c->cpu_ns);
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
    cost best = {INFINITY, INFINITY}, worst = {0.0, 0.0};
    printf("%9s %9s %9s %10s %10s\n", "objects", "median ms", "least", "ns/object", "CPU ns");
    for (uint32_t n = 250000; n <= most; n *= 2) {
        cost c = {0.0, 0.0};
        if (!measure(n, options, &c, err))
            return false;
        best = (cost){fmin(best.ns, c.ns), fmin(best.cpu_ns, c.cpu_ns)};
        worst = (cost){fmax(worst.ns, c.ns), fmax(worst.cpu_ns, c.cpu_ns)};
    }
    printf("the worst takes %.2f of the best's time an object (CPU time: %.2f); wanted: 1.4\n",
           worst.ns / best.ns, worst.cpu_ns / best.cpu_ns);
    return true;
}
