// SPDX-License-Identifier: MIT
// What it costs to make a kernel's text, and to count its configs.
#include "bench.h"

#include "base/clock.h"
#include "gen/gen.h"

#include <inttypes.h>
#include <stdio.h>

static const gen_limits limits = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};

static bool time_make(gen *g, const char *kernel, double *us, duet_error *err)
{
    gen_variant variant;
    uint64_t begun = clock_steady_ns();
    if (!gen_make(g, kernel, NULL, 0, &limits, &variant, err))
        return false;
    *us = (double)(clock_steady_ns() - begun) * 1e-3;
    gen_variant_free(&variant);
    return true;
}

static bool time_kernel(gen *g, const char *kernel, uint32_t runs, duet_error *err)
{
    double first = 0, again = 0;
    series made = {.n = 0};
    bool ok = time_make(g, kernel, &first, err);
    for (uint32_t i = 0; ok && i < runs; ++i) {
        ok = time_make(g, kernel, &again, err);
        series_add(&made, again);
    }
    uint64_t configs = 0;
    uint64_t begun = clock_steady_ns();
    ok = ok && gen_count(g, kernel, &limits, &configs, err);
    double counted = (double)(clock_steady_ns() - begun) * 1e-3;
    if (ok)
        printf("%-20s %9.1f %9.1f %9" PRIu64 " %9.1f\n", kernel, first, series_median(&made),
               configs, counted);
    return ok;
}

bool bench_generate(const bench_options *options, duet_error *err)
{
    gen *g = gen_open(NULL, err);
    if (!g)
        return false;
    printf("microseconds         first text    others   configs   counted\n");
    bool ok = true;
    for (uint32_t i = 0; ok && gen_kernel(g, i); ++i)
        ok = time_kernel(g, gen_kernel(g, i), options->runs, err);
    gen_close(g);
    return ok;
}
