// SPDX-License-Identifier: MIT
// Prints how near each strategy comes to the best share, and at what cost, on
// invented device pairs: the table of docs/tuning.md. --n is the device pairs
// a row.
#include "bench.h"

#include "base/compare.h"
#include "support/any_strategy.h"
#include "support/simulated_pair.h"

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

static double single(const simulated_pair *model)
{
    uint64_t a = simulated_launch(model, SEARCH_ONE, NULL).total_ns;
    uint64_t b = simulated_launch(model, 0, NULL).total_ns;
    return (double)(a < b ? a : b);
}

static void run_pair(const char *name, const simulated_pair *model, rng *r, uint32_t i, row *out)
{
    search s;
    uint64_t cost;
    must(any_strategy_begin(&s, name, ERR));
    must(simulated_run(&s, model, r, &cost, ERR));
    double best = (double)simulated_best(model).total_ns;
    double picked = (double)simulated_launch(model, search_pick(&s), NULL).total_ns;
    out->off[i] = picked / best - 1;
    out->launches += s.n;
    out->cost += (double)cost / best;
    out->slower += picked > 1.001 * single(model);
    any_strategy_end(&s);
}

static void print_row(const char *family, const noise *n, const char *name, row *out,
                      uint32_t pairs)
{
    double sum = 0;
    for (uint32_t i = 0; i < pairs; ++i)
        sum += out->off[i];
    qsort(out->off, pairs, sizeof *out->off, compare_double);
    printf("| %-6s | %-13s | %-8s | %8.1f | %6.2f %% | %5.1f %% | %5.1f | %4.1f %% |\n", family,
           n->name, name, out->launches / pairs, 100 * sum / pairs,
           100 * out->off[pairs * 95 / 100], out->cost / pairs, 100 * out->slower / pairs);
}

static void print_family(simulated_family family, const noise *n, uint32_t pairs, uint64_t seed)
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
            run_pair(any_strategies[k], &model, &launches, i, &out);
        }
        print_row(families[family], n, any_strategies[k], &out, pairs);
    }
}

void bench_strategies(const bench_options *options)
{
    uint32_t pairs = options->n ? options->n : 300;
    must(pairs <= MOST_PAIRS ||
         error_set(ERR, DUET_STATUS_BAD_ARGUMENT, "--n %u: at most %d device pairs a row", pairs,
                   MOST_PAIRS));
    printf(
        "| model  | noise         | strategy | launches | mean off | p95 off | cost  | slower |\n"
        "|--------|---------------|----------|----------|----------|---------|-------|--------|\n");
    for (size_t i = 0; i < sizeof noises / sizeof *noises; ++i)
        for (int family = SIMULATED_AFFINE; family <= SIMULATED_FIXED; ++family)
            print_family((simulated_family)family, &noises[i], pairs, options->seed);
}
