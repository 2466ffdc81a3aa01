// SPDX-License-Identifier: MIT
// Searches for kernels and share, by the default strategy, on invented device pairs with 12 configs
// each. A search begins from the configs that are the default ones: any, or device B's best.
#include "bench.h"

#include "support/kernel_pair.h"

enum { UNIT_NS = 500000 }; // of a launch that takes 1

static const struct {
    double sigma;
    const char *noise;
} noises[] = {{0.2, "20 %"}, {0.05, "5 %"}};

typedef struct kind {
    const char *name;
    bool a_is_quicker, is_alike, from_best;
} kind;

static const kind kinds[] = {{"A; any", .a_is_quicker = true},
                             {"A; the best", .a_is_quicker = true, .from_best = true},
                             {"B; any", .a_is_quicker = false},
                             {"B; the best", .from_best = true},
                             {"both alike; any", .is_alike = true},
                             {"both alike; the best", .is_alike = true, .from_best = true}};

static void draw(kernel_pair *f, const kind *of)
{
    kernel_pair_invent(f);
    if (of->a_is_quicker)
        f->slower = 1 / f->slower;
    if (of->is_alike)
        kernel_pair_equal(f);
    f->space.now =
        of->from_best ? kernel_pair_best(f) : (uint32_t)rng_below(&f->random, KERNEL_PAIR_CONFIGS);
}

static void print_row(const char *noise, double sigma, const kind *of, uint32_t pairs,
                      uint64_t seed)
{
    kernel_pair f = {.random = rng_seed(seed), .unit_ns = UNIT_NS, .sigma = sigma};
    double off = 0, trials = 0;
    uint32_t more = 0;
    for (uint32_t i = 0; i < pairs; ++i) {
        duet_tune_outcome o;
        trial_log log = {0};
        draw(&f, of);
        must(kernel_pair_tune(&f, "balance", NULL, &log, &o, ERR));
        trial_log_free(&log);
        off += kernel_pair_time_of_plan(&f, &o.plan) / kernel_pair_least_time(&f) - 1;
        trials += o.trials;
        more += 10 * o.trials > kernel_pair_plans(&f);
    }
    printf("| %-5s | %-20s | %5.1f %% | %6.0f | %4.1f %% |\n", noise, of->name, 100 * off / pairs,
           trials / pairs, 100.0 * more / pairs);
    fflush(stdout);
}

void bench_pairs(const bench_options *options)
{
    uint32_t pairs = options->n ? options->n : 300;
    printf("| noise | quicker; from        | off     | trials | above a tenth |\n"
           "|-------|----------------------|---------|--------|---------------|\n");
    for (size_t i = 0; i < sizeof noises / sizeof *noises; ++i)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k)
            print_row(noises[i].noise, noises[i].sigma, &kinds[k], pairs, options->seed);
}
