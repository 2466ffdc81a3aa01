// SPDX-License-Identifier: MIT
// Strategies that choose kernels and share together, on two kernels that are only arithmetic.
#include "support/test.h"

#include "support/kernel_pair.h"
#include "support/recorded.h"
#include "support/store.h"
#include "tuner/joint_space.h"
#include "tuner/strategy.h"
#include "tuner/tune.h"

static duet_tune_outcome tune_fake(kernel_pair *f, const char *name)
{
    duet_tune_outcome o;
    own(trial_log) log = {0};
    must(kernel_pair_tune(f, name, NULL, &log, &o, ERR));
    return o;
}

// ---------------------------------------------------------------- the space

static joint_space open_space(const kernel_pair *f)
{
    joint_space s = {.points = KERNEL_PAIR_POINTS};
    for (int device = 0; device < 2; ++device)
        must(joint_space_add(&s, device, &f->space, ERR));
    return s;
}

TEST(every_plan_of_the_grid_has_one_number)
{
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    kernel_pair_invent(&f);
    own(joint_space) s = open_space(&f);
    uint64_t n = joint_space_count(&s);
    assert_int_equal(n, kernel_pair_plans(&f));
    bool seen[KERNEL_PAIR_POINTS + 1][KERNEL_PAIR_CONFIGS][KERNEL_PAIR_CONFIGS] = {{{false}}};
    for (uint64_t i = 0; i < n; ++i) {
        search_sample p = joint_space_at(&s, i), same = p;
        uint32_t point = p.share / (SEARCH_ONE / KERNEL_PAIR_POINTS);
        assert_int_equal(p.share % (SEARCH_ONE / KERNEL_PAIR_POINTS), 0);
        joint_space_normalize(&s, &same);
        assert_true(memcmp(p.configs, same.configs, sizeof p.configs) == 0 &&
                    p.share == same.share);
        assert_false(seen[point][p.configs[0]][p.configs[1]]);
        seen[point][p.configs[0]][p.configs[1]] = true;
    }
}

// Eight kernels of 12 configs: more than a search goes through, and more than 64 bits count.
TEST(many_kernels_leave_a_number_of_plans)
{
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    kernel_pair_invent(&f);
    own(joint_space) s = {.points = KERNEL_PAIR_POINTS};
    for (int device = 0; device < 2; ++device)
        for (int i = 0; i <= SEARCH_KERNELS; ++i) // one more than there is space for
            must(joint_space_add(&s, device, &f.space, ERR));
    assert_int_equal(s.kernels.n, 2 * SEARCH_KERNELS);
    const uint64_t most = UINT64_C(1) << 24;
    uint64_t n = joint_space_count(&s);
    assert_true(n == most * most * (KERNEL_PAIR_POINTS - 1) + 2 * most);
    search_sample last = joint_space_at(&s, n - 1);
    for (uint32_t i = 0; i < s.kernels.n; ++i)
        assert_true(last.configs[i] < KERNEL_PAIR_CONFIGS);
}

TEST(a_neighbour_differs_in_one_parameter_or_in_the_share)
{
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    kernel_pair_invent(&f);
    own(joint_space) s = open_space(&f);
    for (int i = 0; i < 2000; ++i) {
        search_sample p = joint_space_random(&s, &f.random);
        search_sample to = joint_space_neighbour(&s, &p, &f.random);
        if (p.share == 0 || p.share == SEARCH_ONE || to.share == 0 || to.share == SEARCH_ONE)
            continue;
        uint32_t differ = p.share != to.share;
        for (int device = 0; device < 2; ++device)
            for (uint32_t k = 0; k < 2; ++k)
                differ +=
                    f.space.configs[p.configs[device]][k] != f.space.configs[to.configs[device]][k];
        assert_true(differ <= 1);
    }
}

// ---------------------------------------------------------------- strategies

TEST(brute_force_finds_the_best_plan_of_all)
{
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    for (int i = 0; i < 5; ++i) {
        kernel_pair_invent(&f);
        duet_tune_outcome o = tune_fake(&f, "brute");
        assert_int_equal(o.plans, kernel_pair_plans(&f));
        assert_int_equal(o.plans_tried, o.plans);
        // the verdict may even the share out between those of the grid
        assert_true(kernel_pair_time_of_plan(&f, &o.plan) <= kernel_pair_least_time(&f) + 1e-12);
    }
}

TEST(a_tenth_of_the_plans_comes_near_the_best)
{
    static const struct {
        const char *strategy;
        double mean; // at most so much above the best
    } cases[] = {{"random", 0.06}, {"annealing", 0.02}, {"balance", 0.02}};
    enum { TIMES = 25 };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        kernel_pair f = {.random = rng_seed(test_seed() + 1), .unit_ns = 1e7, .sigma = 0.01};
        double mean = 0, worst = 0;
        for (int i = 0; i < TIMES; ++i) {
            kernel_pair_invent(&f);
            duet_tune_outcome o = tune_fake(&f, cases[k].strategy);
            double off = kernel_pair_time_of_plan(&f, &o.plan) / kernel_pair_least_time(&f) - 1;
            mean += off / TIMES;
            worst = fmax(worst, off);
            assert_true(10 * o.plans_tried <= o.plans);
        }
        print_message("%s: %.1f %% above the best in the mean, %.1f %% at worst\n",
                      cases[k].strategy, 100 * mean, 100 * worst);
        assert_true(mean <= cases[k].mean);
    }
}

// Times scatter as on a quiet machine, and most of the trials are the races that prove what was
// found. A quarter of the pairs are of one kind.
TEST(a_tuning_takes_a_tenth_of_the_trials_of_brute_force)
{
    enum { TIMES = 60 };
    kernel_pair f = {.random = rng_seed(test_seed() + 2), .unit_ns = 1e7, .sigma = 0.05};
    double trials = 0, off = 0;
    uint32_t plans = 0;
    for (int i = 0; i < TIMES; ++i) {
        kernel_pair_invent(&f);
        if (i % 4 == 0)
            kernel_pair_equal(&f);
        f.space.now = i % 2 ? f.space.now : kernel_pair_best(&f);
        duet_tune_outcome o = tune_fake(&f, "balance");
        plans = kernel_pair_plans(&f);
        trials += o.trials / (double)TIMES;
        off += (kernel_pair_time_of_plan(&f, &o.plan) / kernel_pair_least_time(&f) - 1) / TIMES;
    }
    print_message("%.0f trials of %u in the mean, %.1f %% above the best\n", trials, plans,
                  100 * off);
    assert_true(10 * trials <= plans);
    assert_true(off <= 0.03);
}

// Two devices of one kind. The plans that are raced beside the single device hardly differ, and it
// is enough to choose one; the expected one then has all rounds, so that a half each is proven
// to take less than one device also at noise that hides which plan is best.
TEST(few_tunings_of_equal_devices_take_more_than_a_tenth_or_share_nothing)
{
    enum { TIMES = 100 };
    static const struct {
        double sigma, off;
        uint32_t more, alone; // at most
    } cases[] = {{0.1, 0.04, 6, 1}, {0.3, 0.2, 20, 6}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        kernel_pair f = {
            .random = rng_seed(test_seed() + 3), .unit_ns = 1e7, .sigma = cases[k].sigma};
        uint32_t more = 0, alone = 0;
        double trials = 0, off = 0;
        for (int i = 0; i < TIMES; ++i) {
            kernel_pair_invent(&f);
            kernel_pair_equal(&f);
            f.space.now = i % 2 ? f.space.now : kernel_pair_best(&f);
            duet_tune_outcome o = tune_fake(&f, "balance");
            uint32_t plans = kernel_pair_plans(&f);
            trials += o.trials / (double)TIMES;
            off += (kernel_pair_time_of_plan(&f, &o.plan) / kernel_pair_least_time(&f) - 1) / TIMES;
            more += 10 * o.trials > plans;
            alone += o.plan.share == 0 || o.plan.share == DUET_SHARE_ONE;
        }
        print_message("%.0f trials in the mean, %u times more than a tenth, %.1f %% above the "
                      "best, %u times one device\n",
                      trials, more, 100 * off, alone);
        assert_true(more <= cases[k].more && alone <= cases[k].alone && off <= cases[k].off);
    }
}

// On both devices all sets of parameters take half as much again, but for two.
static void set_factors(kernel_pair *f, uint32_t one, double factor, uint32_t best)
{
    for (int device = 0; device < 2; ++device) {
        for (uint32_t c = 0; c < KERNEL_PAIR_CONFIGS; ++c)
            f->factor[device][c] = 1.5;
        f->factor[device][one] = factor;
        f->factor[device][best] = 1;
    }
}

// One set of parameters takes 15 % less than the default one, and all others take half as much
// again. No race of two dozen rounds is 99 % sure of that at such noise, but it mostly shows which
// is the better.
TEST(a_set_that_takes_much_less_is_mostly_found_where_times_scatter)
{
    enum { TIMES = 100, BETTER = 4 };
    kernel_pair f = {.random = rng_seed(test_seed() + 4), .unit_ns = 1e6, .sigma = 0.15};
    uint32_t kept[2] = {0};
    for (int i = 0; i < TIMES; ++i) {
        kernel_pair_invent(&f);
        f.slower = 0.5;
        set_factors(&f, f.space.now, 1.15, BETTER);
        duet_tune_outcome o = tune_fake(&f, "balance");
        kept[0] += kernel_pair_config(&f, o.plan.variant_a) != BETTER;
        kept[1] += kernel_pair_config(&f, o.plan.variant_b) != BETTER;
    }
    print_message("another set than the best, of %d: %u times on A, %u on B\n", TIMES, kept[0],
                  kept[1]);
    assert_true(kept[0] <= 45 && kept[1] <= 45);
}

// Short launches that tell the same each time, or that other programs disturb, count as often as
// long ones do; others more often.
TEST(short_launches_count_more_often_only_if_they_scatter)
{
    enum { TIMES = 20 };
    static const struct {
        double unit_ns, sigma;
        bool waits; // for a core
    } cases[] = {{1e7, 0.01, false}, {1e6, 0.01, false}, {1e6, 0.2, false}, {1e6, 0.2, true}};
    double a_trial[4] = {0}; // launches
    for (int k = 0; k < 4; ++k) {
        kernel_pair f = {.random = rng_seed(test_seed() + 9),
                         .unit_ns = cases[k].unit_ns,
                         .sigma = cases[k].sigma,
                         .waits = cases[k].waits,
                         .repeats = 3};
        for (int i = 0; i < TIMES; ++i) {
            kernel_pair_invent(&f);
            duet_tune_outcome o = tune_fake(&f, "balance");
            a_trial[k] += (double)o.launches / o.trials / TIMES;
        }
    }
    print_message(
        "launches a trial: long %.1f, steady %.1f, scattering %.1f, waiting for a core %.1f\n",
        a_trial[0], a_trial[1], a_trial[2], a_trial[3]);
    assert_true(a_trial[1] < 1.2 * a_trial[0] && a_trial[3] < 1.2 * a_trial[0]);
    assert_true(a_trial[2] > 1.5 * a_trial[0]);
}

// Two devices of one kind share a half each, and what is best for one that works alone may not be
// while both work: on what they have in common, such as the way to memory.
TEST(equal_devices_get_the_kernels_that_are_best_while_both_work)
{
    enum { TIMES = 50, BEST = 4, ALONE = 3 };
    kernel_pair f = {.random = rng_seed(test_seed() + 6), .unit_ns = 1e7, .sigma = 0.01};
    for (int i = 0; i < TIMES; ++i) {
        kernel_pair_invent(&f);
        f.slower = 1;
        set_factors(&f, BEST, 1.1, ALONE);
        f.crowded[ALONE] = 0.3;
        duet_tune_outcome o = tune_fake(&f, "balance");
        assert_true(o.plan.share > 0 && o.plan.share < DUET_SHARE_ONE);
        assert_int_equal(kernel_pair_config(&f, o.plan.variant_a), BEST);
        assert_int_equal(kernel_pair_config(&f, o.plan.variant_b), BEST);
    }
}

// The plans of a search fit the budget, and what sharing loses is told, though no plan that shares
// is among the best few.
TEST(a_small_budget_is_enough_for_a_verdict_on_sharing)
{
    static const char *const names[] = {"random", "annealing"};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        kernel_pair f = {
            .random = rng_seed(test_seed() + 5), .unit_ns = 1e7, .sigma = 0.01, .most_trials = 90};
        for (int i = 0; i < 20; ++i) {
            kernel_pair_invent(&f);
            f.slower = 400; // even a sixteenth on A takes 25 times as long as all on B
            duet_tune_outcome o = tune_fake(&f, names[k]);
            assert_true(o.trials <= f.most_trials);
            assert_int_equal(o.plan.share, 0);
            assert_true(o.best.share > 0 && o.best.share < DUET_SHARE_ONE);
            assert_string_equal(o.verdict, "slower");
            assert_true(o.gain_high < -0.5);
        }
    }
}

// A trial is a launch to warm up and three that count, or one if they take a second.
TEST(long_launches_count_once)
{
    double launches[2]; // a trial
    for (int i = 0; i < 2; ++i) {
        kernel_pair f = {.random = rng_seed(test_seed() + 7),
                         .unit_ns = i == 0 ? 2e7 : 2e10,
                         .sigma = 0.01,
                         .repeats = 3};
        kernel_pair_invent(&f);
        duet_tune_outcome o = tune_fake(&f, "random");
        assert_int_equal(o.launches, f.launches);
        launches[i] = (double)o.launches / o.trials;
    }
    assert_true(launches[0] > 3 && launches[1] <= 2.1); // the first trial counts three
}

TEST(no_plan_is_measured_twice)
{
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    kernel_pair_invent(&f);
    own(joint_space) s = open_space(&f);
    for (int k = 0; strategies[k]; ++k) {
        if (strategies[k]->choice == STRATEGY_SHARE)
            continue;
        search h = {.space = &s, .seed = 3, .options.launches = 300};
        while (h.n < 300) {
            search_next next;
            must(strategies[k]->ask(&h, &next, ERR));
            if (next.done)
                break;
            assert_null(search_find(&h, &next.at));
            search_sample sample = next.at;
            sample.failed = rng_below(&f.random, 9) == 0;
            sample.total_ns = 1000 + rng_below(&f.random, 1000);
            must(search_tell(&h, &sample, ERR));
        }
        assert_int_equal(h.n, 300);
        search_end(&h);
    }
}

// Stopped after every few trials, and taken up from the store each time.
TEST(a_resumed_search_ends_as_an_uninterrupted_one)
{
    static const char *const names[] = {"random", "annealing"};
    for (int k = 0; k < 2; ++k) {
        kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
        kernel_pair_invent(&f);
        duet_tune_outcome expected = tune_fake(&f, names[k]), o;
        duet_error err = {0};
        trial_log log = {0};
        uint32_t stops = 0;
        record r = test_record(test_store_fresh());
        f.record = &r;
        for (f.stop_after = 9; !kernel_pair_tune(&f, names[k], NULL, &log, &o, &err); ++stops) {
            assert_int_equal(err.status, DUET_STATUS_INTERRUPTED);
            err = (duet_error){0};
            test_record_again(&r, &log);
        }
        assert_true(stops > 10);
        assert_string_equal(o.plan.variant_a, expected.plan.variant_a);
        assert_string_equal(o.plan.variant_b, expected.plan.variant_b);
        assert_int_equal(o.plan.share, expected.plan.share);
        trial_log_free(&log);
    }
}

// ---------------------------------------------------------------- scripts

static bool tune_by(kernel_pair *f, const char *chars, duet_tune_outcome *o, duet_error *err)
{
    own(trial_log) log = {0};
    script *own = strategy_lua_open("s.lua", chars, err);
    bool ok = own && kernel_pair_tune(f, "lua", own, &log, o, err);
    script_close(own);
    return ok;
}

// It sees all of the space: the configs' values, the grid, and what each plan took.
TEST(a_script_searches_kernels_and_share_together)
{
    static const char chars[] =
        "local function best(history)\n"
        "  local at = history[1]\n"
        "  for _, h in ipairs(history) do if h.ok and h.total < at.total then at = h end end\n"
        "  return at\n"
        "end\n"
        "return { joint = function(space, history)\n"
        "  local a, b = space.kernels[1], space.kernels[2]\n"
        "  assert(a.device == 'A' and b.device == 'B' and a.name == 'k' and #space.shares == 17)\n"
        "  assert(a.configs[2].SIZE == 1 and a.configs[2].TILE == 1 and a.now == 6)\n"
        "  local n, na = #history, #a.configs\n"
        "  if n < na then return { share = 0.5, configs = { n + 1, b.now } } end\n"
        "  local from = { table.unpack(history, 1, na) }\n"
        "  table.sort(from, function(x, y) return x.a < y.a end)\n"
        "  if n < 2 * na then return { share = 0.5, configs = { from[1].configs[1], n - na + 1 } } "
        "end\n"
        "  local of_b = { table.unpack(history, na + 1, 2 * na) }\n"
        "  table.sort(of_b, function(x, y) return x.b < y.b end)\n"
        "  local configs = { from[1].configs[1], of_b[1].configs[2] }\n"
        "  if n < 2 * na + 17 then return { share = space.shares[n - 2 * na + 1], configs = "
        "configs } end\n"
        "end }\n";
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    for (int i = 0; i < 5; ++i) {
        duet_tune_outcome o;
        kernel_pair_invent(&f);
        must(tune_by(&f, chars, &o, ERR));
        assert_int_equal(o.plans_tried, 2 * KERNEL_PAIR_CONFIGS + KERNEL_PAIR_POINTS + 1);
        assert_true(kernel_pair_time_of_plan(&f, &o.plan) <= kernel_pair_least_time(&f) + 1e-12);
    }
}

TEST(a_script_that_gives_no_plan_is_told_what_was_expected)
{
    static const char *const wrong[][2] = {
        {"return { joint = 3 }", "expected a function of the history"},
        {"return { joint = function() return 0.5 end }", "expected { share =, configs = } or nil"},
        {"return { joint = function() return { share = 2 } end }", "expected 0 to 1"},
        {"return { joint = function() return { share = 0.5, configs = { 13, 1 } } end }",
         "config 1 is 13; expected 1 to 12"},
    };
    kernel_pair f = {.random = rng_seed(test_seed()), .unit_ns = 1e7};
    kernel_pair_invent(&f);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        duet_tune_outcome o;
        must_fail(tune_by(&f, wrong[i][0], &o, ERR), DUET_STATUS_BAD_INPUT, wrong[i][1]);
    }
}
