// SPDX-License-Identifier: MIT
// Prints how near each strategy comes to the best share, and at what cost, on
// invented device pairs: the table of docs/tuning.md. --n is the device pairs
// a row.
#include "bench.h"

#include "support/any_strategy.h"
#include "support/simulated_pair.h"

#include <stdio.h>
#include <stdlib.h>

enum { MOST_PAIRS = 10000 };

typedef struct noise {
    const char *name;
    double sigma;
    double spike_chance;
} noise;

static const noise noises[] = {
    {"none", 0, 0},
    {"2 %", 0.02, 0},
    {"5 % + spikes", 0.05, 0.05},
    {"15 % + spikes", 0.15, 0.10},
};

static const char *const families[] = {"affine", "steps", "interf", "fixed"};

typedef struct row {
    double launches;
    double cost;
    double slower; // part of the pairs that end slower than the better device
    double off[MOST_PAIRS];
} row;

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double single(const simulated_pair *model)
{
    uint64_t a = simulated_launch(model, SEARCH_ONE, NULL).total_ns;
    uint64_t b = simulated_launch(model, 0, NULL).total_ns;
    return (double)(a < b ? a : b);
}

static bool run_pair(const char *name, const simulated_pair *model, rng *r, uint32_t i, row *out,
                     duet_error *err)
{
    search s;
    uint64_t cost;
    bool ok = any_strategy_begin(&s, name, err) && simulated_run(&s, model, r, &cost, err);
    if (ok) {
        double best = (double)simulated_best(model).total_ns;
        double picked = (double)simulated_launch(model, search_pick(&s), NULL).total_ns;
        out->off[i] = picked / best - 1;
        out->launches += s.n;
        out->cost += (double)cost / best;
        out->slower += picked > 1.001 * single(model);
    }
    any_strategy_end(&s);
    return ok;
}

static void print_row(const char *family, const noise *n, const char *name, row *out,
                      uint32_t pairs)
{
    double sum = 0;
    for (uint32_t i = 0; i < pairs; ++i)
        sum += out->off[i];
    qsort(out->off, pairs, sizeof *out->off, by_value);
    printf("| %-6s | %-13s | %-8s | %8.1f | %6.2f %% | %5.1f %% | %5.1f | %4.1f %% |\n", family,
           n->name, name, out->launches / pairs, 100 * sum / pairs,
           100 * out->off[pairs * 95 / 100], out->cost / pairs, 100 * out->slower / pairs);
}

static bool print_family(simulated_family family, const noise *n, uint32_t pairs, uint64_t seed,
                         duet_error *err)
{
    static row out;
    for (uint32_t k = 0; any_strategies[k]; ++k) {
        rng r = rng_seed(seed);
        out = (row){0};
        for (uint32_t i = 0; i < pairs; ++i) {
            simulated_pair model = simulated_invent(family, false, &r);
            model.sigma = n->sigma;
            model.spike_chance = n->spike_chance;
            model.spike_most = 3;
            rng launches = rng_seed(rng_next(&r));
            if (!run_pair(any_strategies[k], &model, &launches, i, &out, err))
                return false;
        }
        print_row(families[family], n, any_strategies[k], &out, pairs);
    }
    return true;
}

bool bench_strategies(const bench_options *options, duet_error *err)
{
    uint32_t pairs = options->n ? options->n : 300;
    bool ok = pairs <= MOST_PAIRS ||
              error_set(err, DUET_STATUS_BAD_ARGUMENT, "--n %u: at most %d device pairs a row",
                        pairs, MOST_PAIRS);
    if (ok)
        printf(
            "| model  | noise         | strategy | launches | mean off | p95 off | cost  | slower "
            "|\n"
            "|--------|---------------|----------|----------|----------|---------|-------|--------"
            "|\n");
    for (size_t i = 0; ok && i < sizeof noises / sizeof *noises; ++i) {
        for (int family = SIMULATED_AFFINE; ok && family <= SIMULATED_FIXED; ++family)
            ok = print_family((simulated_family)family, &noises[i], pairs, options->seed, err);
    }
    return ok;
}
