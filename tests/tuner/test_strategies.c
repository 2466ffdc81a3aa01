// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "base/compare.h"
#include "support/any_strategy.h"
#include "support/program.h"
#include "support/simulated_pair.h"

// Runs a strategy to its end on a model and gives its pick.
static uint32_t pick_of(const char *name, const simulated_pair *model, rng *r, uint32_t *launches,
                        double *cost)
{
    search s;
    uint64_t cost_ns;
    must(any_strategy_begin(&s, name, ERR));
    must(simulated_run(&s, model, r, &cost_ns, ERR));
    uint32_t share = search_pick(&s);
    if (launches)
        *launches = s.n;
    if (cost)
        *cost = (double)cost_ns / (double)simulated_best(model).total_ns;
    any_strategy_end(&s);
    return share;
}

// The facts of figure 12 in exact arithmetic: T(r) = max(K r, 1 - r).
typedef struct fig12_row {
    double ratio;
    double share;        // after 13 launches
    double off_percent;  // above the best total
    double lost_percent; // part of the gain over the faster device
    double cost;         // cost of all launches, in best totals
} fig12_row;

static const fig12_row fig12_table[] = {
    {3, .2500, 0.0, 0, 17.7},    {5, .1250, 5.0, 25, 21.3},     {10, .0625, 3.1, 31, 30.0},
    {20, .03125, 1.7, 34, 48.9}, {50, .015625, 0.4, 20, 107.5},
};

TEST(fig12_gives_the_table_of_the_paper_in_exact_arithmetic)
{
    for (size_t i = 0; i < sizeof fig12_table / sizeof *fig12_table; ++i) {
        const fig12_row *row = &fig12_table[i];
        simulated_pair model = {.ratio = row->ratio};
        uint32_t launches;
        double cost;
        uint32_t share = pick_of("fig12", &model, NULL, &launches, &cost);
        double off = simulated_excess(&model, share);
        double best = row->ratio / (row->ratio + 1);
        double lost = best * off / (1 - best);
        assert_int_equal(launches, 13);
        assert_int_equal(share, (uint32_t)(row->share * SEARCH_ONE));
        assert_true(fabs(100 * off - row->off_percent) < 0.06);
        assert_true(fabs(100 * lost - row->lost_percent) < 0.6);
        assert_true(fabs(cost - row->cost) < 0.06);
    }
}

TEST(fig12_never_comes_nearer_with_more_launches)
{
    for (size_t i = 0; i < sizeof fig12_table / sizeof *fig12_table; ++i) {
        simulated_pair model = {.ratio = fig12_table[i].ratio};
        search_options options = search_default_options();
        options.launches = 1003;
        search s;
        must(search_begin(&s, "fig12", &options, ERR));
        must(simulated_run(&s, &model, NULL, NULL, ERR));
        assert_int_equal(search_pick(&s), (uint32_t)(fig12_table[i].share * SEARCH_ONE));
        search_end(&s);
    }
}

// Speed ratios evenly over the logarithm of 1 to 64.
enum { N_RATIOS = 1000 };

static double ratio_at(uint32_t i)
{
    return pow(64, (i + 0.5) / N_RATIOS);
}

TEST(fig12_loses_the_best_share_for_92_percent_of_speed_ratios)
{
    uint32_t lost = 0, far = 0;
    double sum = 0;
    for (uint32_t i = 0; i < N_RATIOS; ++i) {
        simulated_pair model = {.ratio = ratio_at(i)};
        search s;
        uint32_t low, high;
        must(search_begin(&s, "fig12", NULL, ERR));
        must(simulated_run(&s, &model, NULL, NULL, ERR));
        search_bracket(&s, &low, &high);
        double best = SEARCH_ONE / (model.ratio + 1);
        double least = 1e7 * model.ratio / (model.ratio + 1);
        double off = (double)simulated_launch(&model, search_pick(&s), NULL).total_ns / least - 1;
        lost += best < low || best > high;
        far += off > 0.05;
        sum += off;
        search_end(&s);
    }
    assert_in_range(lost, 915, 935);
    assert_in_range(far, 110, 130);
    assert_true(fabs(100 * sum / N_RATIOS - 2.1) < 0.1);
}

TEST(without_noise_bisect_golden_and_grid_find_the_best_share)
{
    static const struct {
        const char *name;
        double off;
    } within[] = {{"bisect", 0.002}, {"golden", 0.01}, {"grid", 0.04}};
    for (uint32_t i = 0; i < N_RATIOS; i += 10) {
        simulated_pair model = {.ratio = ratio_at(i), .overhead = {0.02, 0.01}};
        for (size_t k = 0; k < sizeof within / sizeof *within; ++k) {
            uint32_t share = pick_of(within[k].name, &model, NULL, NULL, NULL);
            assert_true(simulated_excess(&model, share) < within[k].off);
        }
    }
}

// A's time rises with the share and B's falls, by random steps between rows.
enum { N_ROWS = 33 };

static simulated_pair monotone_model(simulated_row *rows, rng *r)
{
    uint64_t a = 0, b = 0;
    double slope_a = exp(rng_between(r, 0, 4)), slope_b = exp(rng_between(r, 0, 4));
    for (uint32_t i = 0; i < N_ROWS; ++i) {
        rows[i] = (simulated_row){.share = i * (SEARCH_ONE / (N_ROWS - 1)), .a_ns = a};
        a += 1000 + (uint64_t)(1e6 * slope_a * rng_unit(r));
    }
    for (uint32_t i = N_ROWS; i-- > 0;) {
        rows[i].b_ns = b;
        b += 1000 + (uint64_t)(1e6 * slope_b * rng_unit(r));
    }
    return (simulated_pair){.rows = rows, .n_rows = N_ROWS};
}

TEST(the_bracket_holds_the_best_share_at_every_step)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 200; ++round) {
        simulated_row rows[N_ROWS];
        simulated_pair model = monotone_model(rows, &r);
        uint32_t best = simulated_best(&model).share;
        search s;
        duet_error err = {0};
        must(search_begin(&s, "balance", NULL, ERR));
        for (search_next next; search_ask(&s, &next, &err) && !next.done;) {
            uint32_t low, high;
            search_sample sample = simulated_launch(&model, next.at.share, NULL);
            must(search_tell(&s, &sample, ERR));
            search_bracket(&s, &low, &high);
            assert_true(low <= best && best <= high);
        }
        search_end(&s);
    }
}

// Pure max(K r, 1 - r) where overhead is 0; `mirrored` makes A the faster one.
static simulated_pair affine_model(uint32_t i, double overhead, bool mirrored)
{
    double ratio = mirrored ? 1 / ratio_at(i) : ratio_at(i);
    double part = overhead * ratio / (ratio + 1);
    return (simulated_pair){.ratio = ratio, .overhead = {part, 0.7 * part}};
}

TEST(balance_is_within_1_percent_in_9_launches_without_noise)
{
    search_options nine = search_default_options();
    nine.launches = 9;
    for (uint32_t i = 0; i < 6 * N_RATIOS; i += 19) {
        simulated_pair model = affine_model(i / 6, 0.07 * (i % 3), i % 2);
        search s;
        must(search_begin(&s, "balance", &nine, ERR));
        must(simulated_run(&s, &model, NULL, NULL, ERR));
        assert_true(simulated_excess(&model, search_pick(&s)) <= 0.01);
        search_end(&s);
    }
}

TEST(balance_is_within_3_percent_on_average_in_16_noisy_launches)
{
    enum { N_PAIRS = 300 };
    double mean = 0, p95 = 0;
    rng r = rng_seed(test_seed());
    search_options sixteen = search_default_options();
    sixteen.launches = 16;
    for (int family = SIMULATED_AFFINE; family <= SIMULATED_INTERF; ++family) {
        double off[N_PAIRS];
        for (uint32_t i = 0; i < N_PAIRS; ++i) {
            simulated_pair model = simulated_invent((simulated_family)family, i % 2, &r);
            model.sigma = 0.05;
            model.spike_chance = 0.05;
            model.spike_most = 3;
            search s;
            must(search_begin(&s, "balance", &sixteen, ERR));
            must(simulated_run(&s, &model, &r, NULL, ERR));
            off[i] = simulated_excess(&model, search_pick(&s));
            mean += off[i] / (3 * N_PAIRS);
            search_end(&s);
        }
        qsort(off, N_PAIRS, sizeof *off, compare_double);
        p95 += off[N_PAIRS * 95 / 100] / 3;
    }
    print_message("mean %.2f %%, 95th percentile %.2f %%\n", 100 * mean, 100 * p95);
    assert_true(mean <= 0.03);
    assert_true(p95 <= 0.09);
}

TEST(balance_never_launches_at_a_share_that_is_dear)
{
    for (uint32_t i = 0; i < N_RATIOS; i += 3) {
        simulated_pair model = affine_model(i, 0.1, false);
        double alone = (double)simulated_launch(&model, 0, NULL).total_ns;
        double most = fmax(3.2, model.ratio / 16 + 0.2);
        uint64_t cost;
        search s;
        must(search_begin(&s, "balance", NULL, ERR));
        must(simulated_run(&s, &model, NULL, &cost, ERR));
        for (uint32_t k = 0; k < s.n; ++k) {
            assert_true((double)s.samples[k].total_ns <= most * alone);
            assert_true(s.samples[k].share < SEARCH_ONE || model.ratio < 1.5);
        }
        assert_true((double)cost <= (16 + model.ratio / 16) * alone);
        search_end(&s);
    }
}

// Two cores shared by both devices: no gain at all and two dips (tuning.md).
TEST(balance_keeps_one_device_where_sharing_only_costs)
{
    static const simulated_row rows[] = {
        {0, 0, 0, 27100000},
        {64, 0, 3000000, 27500000},
        {20316, 0, 27000000, 27800000},
        {32768, 0, 34800000, 30000000},
        {36864, 0, 29400000, 28000000},
        {65536, 0, 51300000, 0},
    };
    simulated_pair model = {.rows = rows, .n_rows = sizeof rows / sizeof *rows};
    uint32_t launches;
    assert_int_equal(pick_of("balance", &model, NULL, &launches, NULL), 0);
    assert_in_range(launches, 3, 32);
}

TEST(a_neighbours_share_is_the_first_probe)
{
    search_options options = search_default_options();
    options.start = SEARCH_ONE / 11;
    simulated_pair model = {.ratio = 10};
    search s;
    uint64_t cost;
    must(search_begin(&s, "balance", &options, ERR));
    must(simulated_run(&s, &model, NULL, &cost, ERR));
    assert_int_equal(s.samples[1].share, options.start);
    assert_true(s.n <= 6);
    assert_true(simulated_excess(&model, search_pick(&s)) < 0.005);
    search_end(&s);
}

TEST(chunks_follow_a_device_that_slows_down)
{
    search_options endless = search_default_options();
    endless.launches = 1000;
    simulated_pair fast = {.ratio = 1}, slow = {.ratio = 5};
    search s;
    must(search_begin(&s, "chunks", &endless, ERR));
    for (int i = 0; i < 30; ++i) {
        const simulated_pair *model = i < 15 ? &fast : &slow;
        search_next next;
        must(search_ask(&s, &next, ERR));
        search_sample sample = simulated_launch(model, next.at.share, NULL);
        must(search_tell(&s, &sample, ERR));
        if (i == 14 || i == 29)
            assert_true(simulated_excess(model, search_pick(&s)) < 0.02);
    }
    search_end(&s);
}

// Times that make no sense lead to no share outside the range, and to an end.
TEST(senseless_times_do_no_harm)
{
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < 500; ++i) {
        search s;
        search_next next;
        duet_error err = {0};
        uint32_t low, high;
        must(any_strategy_begin(&s, any_strategies[i % 6], ERR));
        while (search_ask(&s, &next, &err) && !next.done) {
            uint64_t ns[3];
            for (int k = 0; k < 3; ++k)
                ns[k] = rng_below(&r, 3) ? rng_next(&r) >> rng_below(&r, 32) : 0;
            assert_true(next.at.share <= SEARCH_ONE);
            search_sample sample = {
                .share = next.at.share, .total_ns = ns[0], .a_ns = ns[1], .b_ns = ns[2]};
            must(search_tell(&s, &sample, ERR));
            search_bracket(&s, &low, &high);
            assert_true(s.n < 1000 && search_pick(&s) <= SEARCH_ONE);
        }
        assert_int_equal(err.status, DUET_STATUS_OK);
        any_strategy_end(&s);
    }
}

// A search is its samples: begun anew and told the same, it goes on alike.
static void begin_again(search *s)
{
    search told;
    must(search_begin(&told, s->strategy->name, NULL, ERR));
    for (uint32_t i = 0; i < s->n; ++i)
        must(search_tell(&told, &s->samples[i], ERR));
    told.script = s->script;
    search_end(s);
    *s = told;
}

// Begins again after every launch when `stops` is set.
static uint32_t run_with_stops(const char *name, const simulated_pair *model, bool stops,
                               uint64_t seed, uint32_t *launches)
{
    search s;
    duet_error err = {0};
    rng r = rng_seed(seed);
    must(any_strategy_begin(&s, name, ERR));
    for (search_next next; search_ask(&s, &next, &err) && !next.done;) {
        search_sample sample = simulated_launch(model, next.at.share, &r);
        must(search_tell(&s, &sample, ERR));
        if (stops)
            begin_again(&s);
    }
    uint32_t share = search_pick(&s);
    *launches = s.n;
    any_strategy_end(&s);
    return share;
}

TEST(a_resumed_search_ends_as_an_uninterrupted_one)
{
    uint64_t seed = test_seed();
    simulated_pair model = {.ratio = 7, .overhead = {0.1, 0.05}, .sigma = 0.05};
    for (uint32_t i = 0; any_strategies[i]; ++i) {
        uint32_t n_whole, n_stopped;
        uint32_t whole = run_with_stops(any_strategies[i], &model, false, seed, &n_whole);
        uint32_t stopped = run_with_stops(any_strategies[i], &model, true, seed, &n_stopped);
        assert_int_equal(whole, stopped);
        assert_int_equal(n_whole, n_stopped);
    }
}

TEST(each_strategy_is_in_the_help)
{
    program help = program_run("tune --help");
    const char *row = strstr(help.out, "--strategy S "), *end = strstr(help.out, "--strategy-lua");
    assert_true(row && end && row < end);
    for (uint32_t i = 0; strategies[i]; ++i) {
        const char *name = strategies[i]->name, *at = strstr(row, name);
        if (strcmp(name, "lua") != 0 && (!at || at > end))
            fail_msg("'duet tune --help' does not name the strategy '%s'", name);
    }
}
