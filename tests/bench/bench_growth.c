// SPDX-License-Identifier: MIT
// Time an object from a quarter of a million objects to eight million, at the
// same density.
#include "subject.h"

// The time that a size took for an object.
typedef struct cost {
    double ns;
    double cpu_ns;
} cost;

static cost measure(uint32_t n, const bench_options *options)
{
    duet_pose *poses = bench_poses(n, options);
    subject *s = subject_alone(options, "simd", poses, n);
    subjects_step(&s, 1, options->runs);
    cost c = {series_median(&s->total) * 1e6 / n, series_median(&s->cpu) * 1e6 / n};
    printf("%9u %9.2f %9.2f %10.1f %10.1f\n", n, series_median(&s->total), series_least(&s->total),
           c.ns, c.cpu_ns);
    fflush(stdout);
    subject_close(s);
    free(poses);
    return c;
}

void bench_growth(const bench_options *options)
{
    uint32_t most = options->n ? options->n : 8000000;
    cost best = {INFINITY, INFINITY}, worst = {0.0, 0.0};
    printf("%9s %9s %9s %10s %10s\n", "objects", "median ms", "least", "ns/object", "CPU ns");
    for (uint32_t n = 250000; n <= most; n *= 2) {
        cost c = measure(n, options);
        best = (cost){fmin(best.ns, c.ns), fmin(best.cpu_ns, c.cpu_ns)};
        worst = (cost){fmax(worst.ns, c.ns), fmax(worst.cpu_ns, c.cpu_ns)};
    }
    printf("the worst takes %.2f of the best's time an object (CPU time: %.2f); wanted: 1.4\n",
           worst.ns / best.ns, worst.cpu_ns / best.cpu_ns);
}
