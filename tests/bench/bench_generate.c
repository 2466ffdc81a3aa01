// SPDX-License-Identifier: MIT
// What it costs to make a kernel's text, and to count its configs.
#include "bench.h"

#include "gen/gen.h"

static const gen_limits limits = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};

static double make_us(gen *g, const char *kernel)
{
    gen_variant variant;
    uint64_t begun = clock_steady_ns();
    must(gen_make(g, kernel, NULL, 0, &limits, &variant, ERR));
    double us = (double)(clock_steady_ns() - begun) * 1e-3;
    gen_variant_free(&variant);
    return us;
}

static void time_kernel(gen *g, const char *kernel, uint32_t runs)
{
    series made = {.n = 0};
    uint64_t configs = 0;
    double first = make_us(g, kernel);
    for (uint32_t i = 0; i < runs; ++i)
        series_add(&made, make_us(g, kernel));
    uint64_t begun = clock_steady_ns();
    must(gen_count(g, kernel, &limits, &configs, ERR));
    double counted = (double)(clock_steady_ns() - begun) * 1e-3;
    printf("%-20s %9.1f %9.1f %9" PRIu64 " %9.1f\n", kernel, first, series_median(&made), configs,
           counted);
}

void bench_generate(const bench_options *options)
{
    gen *g = must(gen_open(NULL, ERR));
    printf("microseconds         first text    others   configs   counted\n");
    for (uint32_t i = 0; gen_kernel(g, i); ++i)
        time_kernel(g, gen_kernel(g, i), options->runs);
}
