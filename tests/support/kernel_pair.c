// SPDX-License-Identifier: MIT
#include "support/kernel_pair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A variant that sets what no kernel has ends the program.
static void must_be(bool fact)
{
    if (!fact)
        abort();
}

void kernel_pair_invent(kernel_pair *f)
{
    kernel_space *s = &f->space;
    *s = (kernel_space){.kernel = "k", .stages = {"kernel"}, .n_params = 2, .now = 5};
    snprintf(s->params[0].name, sizeof s->params[0].name, "SIZE");
    snprintf(s->params[1].name, sizeof s->params[1].name, "TILE");
    s->params[0].n_values = KERNEL_PAIR_SIZES;
    s->params[1].n_values = KERNEL_PAIR_TILES;
    for (uint32_t i = 0; i < KERNEL_PAIR_SIZES; ++i)
        s->params[0].values[i] = 1 << i;
    for (uint32_t i = 0; i < KERNEL_PAIR_TILES; ++i)
        s->params[1].values[i] = i;
    for (uint8_t size = 0; size < KERNEL_PAIR_SIZES; ++size)
        for (uint8_t tile = 0; tile < KERNEL_PAIR_TILES; ++tile)
            memcpy(s->configs[s->n_configs++], (uint8_t[]){size, tile}, 2);
    for (int device = 0; device < 2; ++device) {
        double sizes[KERNEL_PAIR_SIZES], tiles[KERNEL_PAIR_TILES];
        for (uint32_t i = 0; i < KERNEL_PAIR_SIZES; ++i)
            sizes[i] = 1 + rng_unit(&f->random);
        for (uint32_t i = 0; i < KERNEL_PAIR_TILES; ++i)
            tiles[i] = 1 + 0.5 * rng_unit(&f->random);
        for (uint32_t c = 0; c < KERNEL_PAIR_CONFIGS; ++c)
            f->factor[device][c] = sizes[c / KERNEL_PAIR_TILES] * tiles[c % KERNEL_PAIR_TILES] *
                                   (1 + 0.1 * rng_unit(&f->random));
    }
    f->slower = 1 + 7 * rng_unit(&f->random);
}

void kernel_pair_equal(kernel_pair *f)
{
    f->slower = 1;
    memcpy(f->factor[0], f->factor[1], sizeof f->factor[0]);
}

static double crowding(const kernel_pair *f, double share, uint32_t config)
{
    return share > 0 && share < 1 ? 1 + f->crowded[config] : 1;
}

double kernel_pair_time_of_a(const kernel_pair *f, double share, uint32_t config)
{
    return f->slower * share * f->factor[0][config] * crowding(f, share, config);
}

double kernel_pair_time_of_b(const kernel_pair *f, double share, uint32_t config)
{
    return (1 - share) * f->factor[1][config] * crowding(f, share, config);
}

double kernel_pair_time(const kernel_pair *f, double share, uint32_t a, uint32_t b)
{
    double shared = share > 0 && share < 1 ? 0.05 : 0;
    double of_a = share > 0 ? kernel_pair_time_of_a(f, share, a) + shared : 0;
    double of_b = share < 1 ? kernel_pair_time_of_b(f, share, b) + shared : 0;
    return fmax(of_a, of_b);
}

double kernel_pair_least_time(const kernel_pair *f)
{
    double least = INFINITY;
    for (uint32_t point = 0; point <= KERNEL_PAIR_POINTS; ++point)
        for (uint32_t a = 0; a < KERNEL_PAIR_CONFIGS; ++a)
            for (uint32_t b = 0; b < KERNEL_PAIR_CONFIGS; ++b)
                least = fmin(least, kernel_pair_time(f, point / (double)KERNEL_PAIR_POINTS, a, b));
    return least;
}

uint32_t kernel_pair_best(const kernel_pair *f)
{
    uint32_t best = 0;
    for (uint32_t c = 1; c < KERNEL_PAIR_CONFIGS; ++c)
        best = f->factor[1][c] < f->factor[1][best] ? c : best;
    return best;
}

uint32_t kernel_pair_config(const kernel_pair *f, const char *variant)
{
    uint32_t size = f->space.now / KERNEL_PAIR_TILES, tile = f->space.now % KERNEL_PAIR_TILES;
    const char *at = strstr(variant, "k.SIZE=");
    if (at)
        for (size = 0; f->space.params[0].values[size] != atoi(at + 7); ++size)
            must_be(size < KERNEL_PAIR_SIZES);
    at = strstr(variant, "k.TILE=");
    tile = at ? (uint32_t)atoi(at + 7) : tile;
    must_be(tile < KERNEL_PAIR_TILES);
    return size * KERNEL_PAIR_TILES + tile;
}

double kernel_pair_time_of_plan(const kernel_pair *f, const duet_plan *plan)
{
    return kernel_pair_time(f, plan->share / 65536.0, kernel_pair_config(f, plan->variant_a),
                            kernel_pair_config(f, plan->variant_b));
}

uint32_t kernel_pair_plans(const kernel_pair *f)
{
    uint32_t n = f->space.n_configs;
    return (KERNEL_PAIR_POINTS - 1) * n * n + 2 * n;
}

static double noisy(kernel_pair *f, double ms)
{
    return ms * (1 + f->sigma * rng_normal(&f->random));
}

static bool launch(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                   duet_error *err)
{
    kernel_pair *f = context;
    double share = plan->share / 65536.0;
    uint32_t a = kernel_pair_config(f, plan->variant_a), b = kernel_pair_config(f, plan->variant_b);
    (void)err;
    ++f->launches;
    launch->use.disturbed = f->waits;
    launch->a_ns =
        share > 0 ? (int64_t)(f->unit_ns * noisy(f, kernel_pair_time_of_a(f, share, a))) : 0;
    launch->b_ns =
        share < 1 ? (int64_t)(f->unit_ns * noisy(f, kernel_pair_time_of_b(f, share, b))) : 0;
    launch->total_ns = (int64_t)(f->unit_ns * noisy(f, kernel_pair_time(f, share, a, b)));
    for (int device = 0; staged && device < 2; ++device)
        launch->stages[launch->n_stages++] =
            (duet_stage){.name = "kernel",
                         .device = device,
                         .ms = (double)(device == 0 ? launch->a_ns : launch->b_ns) * 1e-6};
    return true;
}

static bool read_kernels(void *context, const duet_plan *plan, int device, kernel_spaces *to,
                         duet_error *err)
{
    const kernel_pair *f = context;
    (void)plan, (void)device;
    return kernel_spaces_add(to, &f->space, err);
}

static bool watch(void *context, const duet_tune_progress *p)
{
    const kernel_pair *f = context;
    return f->stop_after == 0 || p->remembered || p->trials % f->stop_after != 0;
}

bool kernel_pair_tune(kernel_pair *f, const char *name, script *own, trial_log *log,
                      duet_tune_outcome *outcome, duet_error *err)
{
    static const char *const one[] = {"auto"};
    static const duet_mode modes[] = {DUET_MODE_OWN};
    const duet_tune_def def = {.strategy = name,
                               .search = "kernels",
                               .variants = one,
                               .n_variants = 1,
                               .modes = modes,
                               .n_modes = 1,
                               .repeats = f->repeats ? f->repeats : 1,
                               .budget_trials = f->most_trials,
                               .seed = 7,
                               .watch = watch,
                               .watch_context = f};
    tune_problem problem = {
        .def = &def,
        .machine = {.context = f, .launch = launch, .read_kernels = read_kernels},
        .plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"},
        .script = own,
        .fair = f->slower == 1 ? SEARCH_ONE / 2 : 0,
        .least_share = 8};
    if (f->record)
        problem.recorder = record_recorder(f->record);
    return tune_run(&problem, log, outcome, err);
}
