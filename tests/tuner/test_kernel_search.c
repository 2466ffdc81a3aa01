// SPDX-License-Identifier: MIT
// The search of kernels' parameters on kernels that are only arithmetic.
#include "support/test.h"

#include "support/recorded.h"
#include "support/store.h"
#include "tuner/kernel_search.h"
#include "tuner/tune.h"

enum { RIGHT = 4711, PARAMS = 4, KERNEL_MS = 6, REST_MS = 4 };

// One kernel on either device. A launch by a config takes the product of its values'
// factors, and values that do not suit each other take longer.
typedef struct fake {
    kernel_space space;
    double factor[PARAMS][KERNEL_SPACE_VALUES];
    double together[PARAMS][KERNEL_SPACE_VALUES][KERNEL_SPACE_VALUES]; // with the next parameter
    double sigma;
    double spike_chance; // chance of a launch that takes up to twice as long
    double cold;         // a config's first launch takes up to so much longer
    bool ran[2][625];    // by device and config's values
    rng random;
    int64_t wrong, broken; // values of P0 that find other pairs, that do not build; 0: none
    uint32_t launches, stop_after;
    uint32_t told;  // how many trials there are, during the search of kernels
    record *record; // that keeps the trials; NULL: none does
} fake;

// The number of values that the kernels that search pairs have on a GPU and on a CPU.
static const uint32_t gpu_values[PARAMS] = {2, 5, 3, 4}, cpu_values[PARAMS] = {4, 4, 3, 1};

static bool is_valid(const uint8_t config[PARAMS])
{
    return config[1] < 4 || config[3] == 0;
}

static void fill_space(fake *f, const uint32_t n_values[PARAMS])
{
    kernel_space *s = &f->space;
    *s = (kernel_space){.kernel = "k", .stages = {"search"}, .n_params = PARAMS};
    for (uint32_t i = 0; i < PARAMS; ++i) {
        snprintf(s->params[i].name, sizeof s->params[i].name, "P%" PRIu32, i);
        s->params[i].n_values = n_values[i];
        for (uint32_t v = 0; v < n_values[i]; ++v)
            s->params[i].values[v] = 1 << v;
    }
    uint8_t c[PARAMS];
    for (c[0] = 0; c[0] < n_values[0]; ++c[0])
        for (c[1] = 0; c[1] < n_values[1]; ++c[1])
            for (c[2] = 0; c[2] < n_values[2]; ++c[2])
                for (c[3] = 0; c[3] < n_values[3]; ++c[3])
                    if (is_valid(c))
                        memcpy(s->configs[s->n_configs++], c, sizeof c);
    s->now = s->n_configs / 2;
}

static void invent(fake *f, const uint32_t n_values[PARAMS])
{
    fill_space(f, n_values);
    memset(f->ran, 0, sizeof f->ran);
    for (uint32_t p = 0; p < PARAMS; ++p)
        for (uint32_t v = 0; v < KERNEL_SPACE_VALUES; ++v) {
            f->factor[p][v] = 1 + 0.5 * rng_unit(&f->random) * rng_unit(&f->random);
            for (uint32_t w = 0; w < KERNEL_SPACE_VALUES; ++w)
                f->together[p][v][w] = 1 + 0.05 * rng_unit(&f->random);
        }
}

static double time_of(const fake *f, const uint8_t config[PARAMS])
{
    double ms = KERNEL_MS;
    for (uint32_t p = 0; p < PARAMS; ++p)
        ms *=
            f->factor[p][config[p]] * f->together[p][config[p]][p + 1 < PARAMS ? config[p + 1] : 0];
    return ms;
}

static double least_time(const fake *f)
{
    double least = 1e9;
    for (uint32_t i = 0; i < f->space.n_configs; ++i) {
        double ms = time_of(f, f->space.configs[i]);
        least = ms < least ? ms : least;
    }
    return least;
}

// The config that a variant's text sets; fails the test where it is not of the space.
static void read_config(const fake *f, const char *variant, uint8_t config[PARAMS])
{
    memcpy(config, f->space.configs[f->space.now], PARAMS);
    for (const char *at = strstr(variant, " k.P"); at; at = strstr(at + 1, " k.P")) {
        int64_t value = strtoll(at + 6, NULL, 10);
        uint32_t v = 0, p = (uint32_t)(at[4] - '0');
        while (v < f->space.params[p].n_values && f->space.params[p].values[v] != value)
            ++v;
        assert_true(v < f->space.params[p].n_values);
        config[p] = (uint8_t)v;
    }
    if (!is_valid(config))
        fail_msg("'%s' was tried, which is not valid", variant);
}

static double disturbed(fake *f, double ms)
{
    ms *= 1 + f->sigma * (rng_unit(&f->random) + rng_unit(&f->random) + rng_unit(&f->random) - 1.5);
    return rng_unit(&f->random) < f->spike_chance ? ms * (1 + rng_unit(&f->random)) : ms;
}

static double coldness(fake *f, int device, const uint8_t config[PARAMS])
{
    uint32_t at = 0;
    for (uint32_t p = 0; p < PARAMS; ++p)
        at = at * 5 + config[p];
    assert_true(at < sizeof f->ran[0]);
    bool ran = f->ran[device][at];
    f->ran[device][at] = true;
    return ran ? 1 : 1 + f->cold * rng_unit(&f->random);
}

// A launch that is not asked for its stages has none.
static bool launch_fake(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                        duet_error *err)
{
    fake *f = context;
    const char *variants[] = {plan->variant_a, plan->variant_b};
    double part[] = {plan->share / 65536.0, 1 - plan->share / 65536.0};
    ++f->launches;
    launch->hash = RIGHT;
    for (int device = 0; device < 2; ++device) {
        uint8_t config[PARAMS];
        read_config(f, variants[device], config);
        int64_t p0 = f->space.params[0].values[config[0]];
        if (part[device] > 0 && p0 == f->broken) {
            strcpy(err->text, "broken does not build");
            err->status = DUET_STATUS_BUILD_FAILED;
            return false;
        }
        if (part[device] > 0 && p0 == f->wrong)
            launch->hash = 1;
        double kernel_ms =
            part[device] * disturbed(f, time_of(f, config)) * coldness(f, device, config);
        double ms = kernel_ms + part[device] * disturbed(f, REST_MS);
        if (staged)
            launch->stages[launch->n_stages++] =
                (duet_stage){.name = "search", .device = device, .ms = kernel_ms};
        *(device == 0 ? &launch->a_ns : &launch->b_ns) = (int64_t)(ms * 1e6);
    }
    launch->total_ns = launch->a_ns > launch->b_ns ? launch->a_ns : launch->b_ns;
    return true;
}

static bool read_fake(void *context, const duet_plan *plan, int device, kernel_spaces *to,
                      duet_error *err)
{
    const fake *f = context;
    (void)plan, (void)device;
    return kernel_spaces_add(to, &f->space, err);
}

// ---------------------------------------------------------------- tunings

static bool watch_fake(void *context, const duet_tune_progress *p)
{
    fake *f = context;
    if (strncmp(p->stage, "kernels", 7) == 0)
        f->told = p->most_trials;
    return f->stop_after == 0 || p->remembered || p->trials % f->stop_after != 0;
}

static duet_tune_def fake_def(fake *f)
{
    static const char *const one[] = {"auto"};
    return (duet_tune_def){.strategy = "balance",
                           .search = "kernels",
                           .variants = one,
                           .n_variants = 1,
                           .repeats = 3,
                           .watch = watch_fake,
                           .watch_context = f};
}

static bool run_fake(fake *f, const duet_tune_def *def, trial_log *state,
                     duet_tune_outcome *outcome, duet_error *err)
{
    tune_problem problem = {
        .def = def,
        .machine = {.context = f, .launch = launch_fake, .read_kernels = read_fake, .hash = RIGHT},
        .plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"},
        .least_share = 8};
    if (f->record)
        problem.recorder = record_recorder(f->record);
    return tune_run(&problem, state, outcome, err);
}

static duet_tune_outcome tune_fake(fake *f, const duet_tune_def *def, trial_log *state)
{
    duet_tune_outcome outcome;
    must(run_fake(f, def, state, &outcome, ERR));
    return outcome;
}

// How much longer the chosen kernel takes than the fastest one.
static double excess(const fake *f, const char *variant)
{
    uint8_t config[PARAMS];
    read_config(f, variant, config);
    return time_of(f, config) / least_time(f) - 1;
}

// The product of two values counts, as of the work-items of a group and what each does: a
// value that is far behind beside one value of the other is the best beside another.
static void invent_products(fake *f)
{
    static const uint32_t n_values[PARAMS] = {4, 3, 1, 1};
    invent(f, n_values);
    f->space.now = rng_below(&f->random, f->space.n_configs);
    double best = 5 * rng_unit(&f->random);
    for (uint32_t v = 0; v < n_values[0]; ++v)
        for (uint32_t w = 0; w < n_values[1]; ++w)
            f->together[0][v][w] = 1 + 0.2 * fabs(v + w - best);
}

TEST(a_value_far_behind_beside_one_other_may_be_the_best_beside_another)
{
    enum { TIMES = 300 };
    fake f = {.random = rng_seed(test_seed() + 1), .sigma = 0.01};
    duet_tune_def def = fake_def(&f);
    uint32_t near = 0, trials = 0;
    for (int i = 0; i < TIMES; ++i) {
        own(trial_log) log = {0};
        invent_products(&f);
        duet_tune_outcome o = tune_fake(&f, &def, &log);
        near += excess(&f, o.plan.variant_b) < 0.03;
        trials += o.trials;
    }
    print_message("near the best %u times of %d, %u trials a tuning\n", near, TIMES,
                  trials / TIMES);
    assert_true(near >= TIMES * 95 / 100);
}

// A kernel that takes a small part of a step has little to gain by a better one that differs in
// all.
TEST(all_of_few_sets_are_tried_only_of_a_kernel_that_takes_most_of_the_time)
{
    static const double parts[] = {1, 0.1}; // of the kernel's usual time
    fake f = {.random = rng_seed(test_seed() + 2), .sigma = 0.01};
    duet_tune_def def = fake_def(&f);
    for (int k = 0; k < 2; ++k) {
        uint32_t tried = 0, all = 0;
        for (int i = 0; i < 50; ++i) {
            own(trial_log) log = {0};
            invent_products(&f);
            for (uint32_t v = 0; v < KERNEL_SPACE_VALUES; ++v)
                f.factor[0][v] *= parts[k];
            duet_tune_outcome o = tune_fake(&f, &def, &log);
            tried += o.kernels[1].tried;
            all += f.space.n_configs;
        }
        print_message("%u of %u tried\n", tried, all);
        assert_int_equal(tried == all, k == 0);
    }
}

// A search of all configs would launch each of them seven times.
TEST(a_search_comes_near_the_best_in_few_launches)
{
    enum { TIMES = 200, REPEATS = 7 };
    static const struct {
        const char *name;
        const uint32_t *n_values;
        double most; // launches, as a part of those
    } kinds[] = {{"gpu", gpu_values, 0.065}, {"cpu", cpu_values, 0.105}};
    fake f = {.random = rng_seed(test_seed()), .sigma = 0.02, .spike_chance = 0.01, .cold = 0.1};
    duet_tune_def def = fake_def(&f);
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        uint32_t near = 0, launches = 0, all = 0;
        double mean = 0;
        for (int i = 0; i < TIMES; ++i) {
            own(trial_log) log = {0};
            invent(&f, kinds[k].n_values);
            duet_tune_outcome o = tune_fake(&f, &def, &log);
            assert_int_equal(o.kernels[1].configs, f.space.n_configs);
            assert_in_range(o.kernels[1].tried, 2, f.space.n_configs - 1);
            double off = excess(&f, o.plan.variant_b);
            near += off <= 0.03;
            mean += off / TIMES;
            launches += o.kernels[1].launches;
            all += REPEATS * f.space.n_configs;
            assert_in_range(f.told, o.trials * 3 / 4, 5 * o.trials);
        }
        print_message("%s: %" PRIu32 " of %d within 3 %%, %.2f %% off; %.1f launches of %.1f\n",
                      kinds[k].name, near, TIMES, 100 * mean, (double)launches / TIMES,
                      (double)all / TIMES);
        assert_true(near >= 0.9 * TIMES && mean < 0.015);
        assert_true(launches <= kinds[k].most * all);
    }
}

// A hair's breadth is noise, and what was chosen by it may not suit the next parameter.
TEST(a_value_is_left_only_for_one_that_gains)
{
    static const struct {
        double other; // time of the other value
        bool taken;
    } cases[] = {{0.995, false}, {0.95, true}, {1.0, false}, {1.05, false}};
    static const uint32_t two_values[PARAMS] = {2, 1, 1, 1};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fake f = {0};
        uint32_t configs[KERNEL_SPACE_VALUES];
        fill_space(&f, two_values);
        kernel_search s = kernel_search_begin(&f.space);
        assert_int_equal(kernel_search_next(&s, configs), 2);
        kernel_search_tell(&s, configs, (double[]){1.0, cases[i].other}, 2);
        assert_int_equal(s.best == f.space.now, !cases[i].taken);
    }
}

// Every other value takes longer: neither noise nor the best of many may hide it.
TEST(what_is_slower_is_not_chosen)
{
    enum { TIMES = 300 };
    fake f = {.random = rng_seed(test_seed()), .sigma = 0.06, .spike_chance = 0.1};
    duet_tune_def def = fake_def(&f);
    uint32_t changed = 0;
    for (int i = 0; i < TIMES; ++i) {
        own(trial_log) log = {0};
        invent(&f, cpu_values);
        const uint8_t *now = f.space.configs[f.space.now];
        for (uint32_t p = 0; p < PARAMS; ++p)
            for (uint32_t v = 0; v < KERNEL_SPACE_VALUES; ++v)
                f.factor[p][v] = v == now[p] ? 1 : 1.2 + 0.5 * rng_unit(&f.random);
        duet_tune_outcome o = tune_fake(&f, &def, &log);
        for (int device = 0; device < 2; ++device) {
            const char *variant = device == 0 ? o.plan.variant_a : o.plan.variant_b;
            changed += strcmp(variant, "auto") != 0;
            assert_string_not_equal(o.kernels[device].verdict, "");
        }
    }
    assert_int_equal(changed, 0);
}

TEST(what_finds_other_pairs_or_does_not_build_is_not_chosen)
{
    fake f = {.random = rng_seed(test_seed()), .sigma = 0.01};
    duet_tune_def def = fake_def(&f);
    own(trial_log) log = {0};
    invent(&f, cpu_values);
    uint8_t now = f.space.configs[f.space.now][0];
    uint8_t wrong = now == 0 ? 1 : 0, broken = now == 3 ? 2 : 3;
    f.wrong = f.space.params[0].values[wrong];
    f.broken = f.space.params[0].values[broken];
    f.factor[0][wrong] = f.factor[0][broken] = 0.1;
    duet_tune_outcome o = tune_fake(&f, &def, &log);
    uint8_t chosen[PARAMS];
    read_config(&f, o.plan.variant_b, chosen);
    assert_int_not_equal(chosen[0], wrong);
    assert_int_not_equal(chosen[0], broken);
}

TEST(kernels_that_do_not_build_at_all_are_said_with_their_reason)
{
    fake f = {.random = rng_seed(test_seed())};
    duet_tune_def def = fake_def(&f);
    own(trial_log) log = {0};
    duet_tune_outcome o;
    invent(&f, cpu_values);
    f.broken = f.space.params[0].values[f.space.configs[f.space.now][0]];
    must_fail(run_fake(&f, &def, &log, &o, ERR), DUET_STATUS_BUILD_FAILED, "broken does not build");
}

// A value that is valid only beside another one of the others is reached all the same.
TEST(values_that_go_together_are_reached)
{
    fake f = {.random = rng_seed(test_seed())};
    duet_tune_def def = fake_def(&f);
    own(trial_log) log = {0};
    invent(&f, gpu_values);
    for (uint32_t p = 0; p < PARAMS; ++p)
        for (uint32_t v = 0; v < KERNEL_SPACE_VALUES; ++v)
            f.factor[p][v] = p == 1 && v == 4 ? 0.2 : 1;
    while (f.space.configs[f.space.now][3] == 0)
        ++f.space.now;
    duet_tune_outcome o = tune_fake(&f, &def, &log);
    uint8_t chosen[PARAMS];
    read_config(&f, o.plan.variant_b, chosen);
    assert_int_equal(chosen[1], 4);
}

// Stopped after every few trials, and taken up from the store each time.
TEST(a_resumed_search_ends_as_an_uninterrupted_one)
{
    fake whole = {.random = rng_seed(test_seed())};
    duet_tune_def def = fake_def(&whole);
    trial_log log = {0};
    invent(&whole, cpu_values);
    fake f = whole;
    duet_tune_outcome expected = tune_fake(&whole, &def, &log), o;
    trial_log_free(&log);
    duet_error err = {0};
    record r = test_record(test_store_fresh());
    f.record = &r;
    f.stop_after = 5;
    def.watch_context = &f;
    uint32_t stops = 0;
    while (!run_fake(&f, &def, &log, &o, &err)) {
        assert_int_equal(err.status, DUET_STATUS_INTERRUPTED);
        err = (duet_error){0};
        test_record_again(&r, &log);
        assert_true(++stops < 200);
    }
    assert_true(stops > 3);
    assert_string_equal(o.plan.variant_a, expected.plan.variant_a);
    assert_string_equal(o.plan.variant_b, expected.plan.variant_b);
    assert_int_equal(o.kernels[1].tried, expected.kernels[1].tried);
    trial_log_free(&log);
}

TEST(a_budget_ends_the_search_and_leaves_the_rest_of_the_tuning)
{
    fake f = {.random = rng_seed(test_seed()), .sigma = 0.02};
    duet_tune_def def = fake_def(&f);
    invent(&f, gpu_values);
    for (def.budget_trials = 70; def.budget_trials < 200; def.budget_trials += 10) {
        own(trial_log) log = {0};
        duet_tune_outcome o = tune_fake(&f, &def, &log);
        assert_in_range(o.trials, 1, def.budget_trials);
        assert_true(o.step_ms > 0);
    }
}

// The first of three launches has a stage more, and its kernel was not disturbed.
static bool launch_clearing(void *context, const duet_plan *plan, bool staged,
                            measure_launch *launch, duet_error *err)
{
    uint32_t *launched = context;
    (void)plan, (void)err;
    assert_true(staged);
    bool first = (*launched)++ == 0;
    if (first)
        launch->stages[launch->n_stages++] = (duet_stage){.name = "clear", .device = 1, .ms = 5.0};
    launch->stages[launch->n_stages++] =
        (duet_stage){.name = "search", .device = 1, .ms = first ? 1.0 : 2.0};
    launch->total_ns = launch->b_ns = first ? 7000000 : 3000000;
    launch->hash = RIGHT;
    return true;
}

TEST(a_kernels_least_time_is_that_of_all_launches_whatever_else_they_did)
{
    static const char *const stages[] = {"search"};
    uint32_t launched = 0;
    const measure_machine machine = {
        .context = &launched, .launch = launch_clearing, .hash = RIGHT};
    const measurement m =
        measure_plan(&machine, &(duet_plan){0}, (measure_way){.repeats = 2, .staged = true});
    assert_string_equal(m.row.outcome, "ok");
    assert_int_equal(launched, 3);
    assert_int_equal(measure_stages_ns(&m.launch, 1, stages, 1), 1000000);
}
