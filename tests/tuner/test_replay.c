// SPDX-License-Identifier: MIT
// Tunings on recorded launches: of invented devices, whose times are known, and of real ones.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "base/compare.h"
#include "profiles/exchange.h"
#include "support/store.h"
#include "tuner/replay.h"
#include "tuner/strategy.h"

enum { INVENTED = 100000, POINTS = 20, LEFT_OUT = 10 };

static const double SPREAD = 0.02;

static test_folder folder;
static store *recorded;

static void open_store(void)
{
    char command[256];
    profile_import_counts counts;
    folder = test_folder_make();
    recorded = kept(store_open(folder.store, STORE_WRITE, ERR));
    snprintf(command, sizeof command, "gzip -dc '%s/surfaces.jsonl.gz'", getenv("DUET_TEST_DATA"));
    FILE *in = popen(command, "r");
    assert_non_null(in);
    must(profile_import(recorded, in, "surfaces.jsonl.gz", &counts, ERR));
    assert_int_equal(pclose(in), 0);
}

// The devices of test_time at shares of twentieths, but not at 1/2: three launches a plan, which
// take SPREAD more from one to the next.
static void record_invented(store *s)
{
    int64_t pair_id, workload_id, number = 0;
    char id[PROFILE_ID];
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(INVENTED);
    workload.name = "invented";
    must(profile_pair_put(s, &pair, &pair_id, ERR));
    must(profile_workload_put(s, &workload, &workload_id, ERR));
    profile_session session = test_session(pair_id, workload_id);
    must(profile_session_begin(s, &session, id, ERR));
    for (int i = 0; i <= POINTS; ++i) {
        if (i == LEFT_OUT)
            continue;
        profile_sample samples[4];
        profile_trial row = test_trial(INVENTED, i / (double)POINTS, samples, 4);
        for (int k = 1; k < 4; ++k) {
            double longer = 1 + SPREAD * (k - 1);
            samples[k].total_ns = llround((double)samples[0].total_ns * longer);
            samples[k].a_ns = llround((double)samples[0].a_ns * longer);
            samples[k].b_ns = llround((double)samples[0].b_ns * longer);
        }
        must(profile_trial_add(s, id, number++, &row, ERR));
    }
}

// The one surface of that many objects in a store; the caller closes *r.
static void open_surface(store *s, uint64_t n, replay *r)
{
    profile_surface *surfaces;
    uint32_t n_surfaces, i = 0;
    must(profile_surfaces_get(s, &surfaces, &n_surfaces, ERR));
    test_keep(surfaces, free);
    while (i < n_surfaces && surfaces[i].n != n)
        ++i;
    assert_true(i < n_surfaces);
    surfaces[0] = surfaces[i];
    must(replay_open(r, s, &surfaces[0], ERR));
}

// Each better than the one before, until no plan is better than what was chosen.
static void check_gains(const replay_outcome *o)
{
    assert_true(o->n_gains > 0 && o->n_gains < REPLAY_GAINS);
    for (uint32_t i = 1; i < o->n_gains; ++i)
        assert_true(o->gains[i].median_ns < o->gains[i - 1].median_ns &&
                    o->gains[i].seconds > o->gains[i - 1].seconds);
    assert_true(o->gains[0].seconds > 0);
    assert_true(o->gains[o->n_gains - 1].seconds <= o->seconds);
    assert_true(o->gains[o->n_gains - 1].median_ns <= o->median_ns);
}

static replay_outcome run(replay *r, const char *name, uint64_t seed)
{
    replay_outcome outcome;
    duet_tune_def def = duet_default_tune_def();
    def.strategy = name;
    def.seed = seed;
    must(replay_run(r, &def, NULL, &outcome, ERR));
    check_gains(&outcome);
    return outcome;
}

// The second of three launches.
static double true_ns(double share)
{
    return (1 + SPREAD) * fmax(test_time(0, INVENTED, share), test_time(1, INVENTED, share));
}

static double replayed_ns(const replay *r, double share)
{
    duet_plan plan = {.share = (uint32_t)(share * DUET_SHARE_ONE), .mode = DUET_MODE_OWN};
    return replay_median_ns(r, &plan);
}

// Each device's times are a line over the shares at which both work.
TEST(a_share_between_two_takes_what_lies_between)
{
    replay r;
    store *s = test_store_fresh();
    record_invented(s);
    open_surface(s, INVENTED, &r);
    assert_int_equal(r.n_points, POINTS);
    assert_true(fabs(replayed_ns(&r, 0.75) - true_ns(0.75)) < 1);
    assert_true(fabs(replayed_ns(&r, 0.73) - true_ns(0.73)) < 20);
    assert_true(fabs(replayed_ns(&r, 0.09) - true_ns(0.09)) < 20);
    // The devices change places at 1/6, where a step takes less than at both shares around it.
    assert_true(fabs(replayed_ns(&r, 1 / 6.0) - true_ns(1 / 6.0)) < 200);
    assert_true(replayed_ns(&r, 1 / 6.0) < 0.99 * r.best->median_ns);
    // A gap is too wide for a line.
    assert_true(fabs(replayed_ns(&r, 0.49) - true_ns(0.45)) < 20);
    assert_true(fabs(replayed_ns(&r, 0.51) - true_ns(0.55)) < 20);
    // No line leads to one device alone.
    assert_true(fabs(replayed_ns(&r, 0) - true_ns(0)) < 1);
    assert_true(fabs(replayed_ns(&r, 1) - true_ns(1)) < 1);
    assert_true(fabs(replayed_ns(&r, 0.01) - true_ns(1.0 / POINTS)) < 1);
    assert_true(fabs(replayed_ns(&r, 0.99) - true_ns(1 - 1.0 / POINTS)) < 1);
    replay_close(&r);
}

// A takes five times as long for an object as B: the best of all twentieths is 3.
TEST(a_strategy_ends_where_the_invented_devices_are_in_balance)
{
    replay r;
    store *s = test_store_fresh();
    record_invented(s);
    open_surface(s, INVENTED, &r);
    assert_int_equal(r.best->plan.share, lround(3.0 * DUET_SHARE_ONE / POINTS));
    for (uint64_t seed = 0; seed < 20; ++seed) {
        replay_outcome o = run(&r, "balance", seed);
        assert_true(o.plan.share > 0 && o.loss < 0.02);
        assert_string_equal(o.plan.variant_b, "auto sort=radix");
        assert_true(o.search_launches > 0 && o.launches > o.search_launches);
        // No launch is quicker than the quickest or slower than the slowest that was recorded.
        assert_true(o.seconds > 1e-9 * true_ns(3.0 / POINTS) / (1 + SPREAD) * o.launches);
        assert_true(o.seconds < 1e-9 * true_ns(1) * (1 + SPREAD) * o.launches);
    }
    replay_close(&r);
}

// ---------------------------------------------------------------- kernels and share

enum { KERNELS = 6, GRID = 16 };

static const struct {
    const char *variant;
    double factor[2]; // of A's and of B's time
} kernels[KERNELS] = {
    {"auto", {1.9, 1.3}},
    {"auto k.WG=16", {1.2, 1.6}},
    {"auto k.WG=64", {1.0, 1.9}},
    {"auto k.TILE=1", {2.3, 1.1}},
    {"auto k.WG=16 k.TILE=1", {1.5, 1.4}},
    {"auto k.WG=64 k.TILE=1", {1.4, 1.0}},
};

static double joint_ns(double share, int a, int b)
{
    return fmax(share > 0 ? kernels[a].factor[0] * test_time(0, INVENTED, share) : 0,
                share < 1 ? kernels[b].factor[1] * test_time(1, INVENTED, share) : 0);
}

static void record_plan(store *s, const char *session, double share, int a, int b)
{
    profile_sample samples[3];
    profile_trial row = test_trial(INVENTED, share, samples, 3);
    int64_t number = test_count(s, "trial");
    for (int k = 0; k < 3; ++k) {
        samples[k].total_ns = llround(joint_ns(share, a, b));
        samples[k].a_ns = llround(joint_ns(share, a, b) * (share > 0));
        samples[k].b_ns = llround(joint_ns(share, a, b) * (share < 1));
    }
    strcpy(row.plan.variant_a, kernels[a].variant);
    strcpy(row.plan.variant_b, kernels[b].variant);
    must(profile_trial_add(s, session, number, &row, ERR));
}

// Keeps what brute force would have: every config of both devices at each share of a grid.
static void record_joint(store *s)
{
    int64_t pair_id, workload_id;
    char id[PROFILE_ID];
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(INVENTED);
    must(profile_pair_put(s, &pair, &pair_id, ERR));
    must(profile_workload_put(s, &workload, &workload_id, ERR));
    profile_session session = test_session(pair_id, workload_id);
    session.strategy = "brute";
    must(profile_session_begin(s, &session, id, ERR));
    for (int k = 0; k < KERNELS; ++k) {
        record_plan(s, id, 0, 0, k);
        record_plan(s, id, 1, k, 0);
        for (int i = 1; i < GRID; ++i)
            for (int b = 0; b < KERNELS; ++b)
                record_plan(s, id, i / (double)GRID, k, b);
    }
}

static double least_joint_ns(void)
{
    double least = INFINITY;
    for (int i = 0; i <= GRID; ++i)
        for (int k = 0; k < KERNELS * KERNELS; ++k)
            least = fmin(least, joint_ns(i / (double)GRID, k / KERNELS, k % KERNELS));
    return least;
}

static void open_joint(store *s, replay *r)
{
    profile_surface *surfaces;
    uint32_t n;
    must(profile_surfaces_get(s, &surfaces, &n, ERR));
    test_keep(surfaces, free);
    assert_true(n > 0 && surfaces[n - 1].joint);
    surfaces[0] = surfaces[n - 1];
    must(replay_open(r, s, &surfaces[0], ERR));
}

// The least of all is known, and random search of a tenth of the plans is seldom far from it.
TEST(kernels_and_share_are_searched_on_what_brute_force_recorded)
{
    enum { SEEDS = 40 };
    static const char *const names[] = {"brute", "annealing", "random"};
    static const double most[] = {1e-9, 0.05, 0.15}; // in the mean
    replay r;
    store *s = test_store_fresh();
    record_joint(s);
    open_joint(s, &r);
    assert_int_equal(r.n_points, 2 * KERNELS + (GRID - 1) * KERNELS * KERNELS);
    assert_true(fabs(r.best->median_ns / least_joint_ns() - 1) < 1e-6);
    for (int device = 0; device < 2; ++device) {
        assert_int_equal(r.spaces[device].n, 1);
        assert_int_equal(r.spaces[device].kernels[0].n_configs, KERNELS);
        assert_string_equal(r.spaces[device].base, "auto");
    }
    for (int k = 0; k < 3; ++k) {
        double mean = 0;
        for (uint64_t seed = 0; seed < (k == 0 ? 2 : SEEDS); ++seed) {
            replay_outcome o = run(&r, names[k], test_seed() + seed), again;
            again = run(&r, names[k], test_seed() + seed);
            assert_memory_equal(&o, &again, sizeof o);
            assert_true(o.search_launches > 0 && o.launches > o.search_launches);
            mean += fmax(o.loss, 0) / (k == 0 ? 2 : SEEDS);
        }
        print_message("%s: %.1f %% above the best in the mean\n", names[k], 100 * mean);
        assert_true(mean <= most[k]);
    }
    replay_close(&r);
}

TEST(a_strategy_for_a_share_alone_needs_another_surface)
{
    replay r;
    replay_outcome o;
    store *s = test_store_fresh();
    record_joint(s);
    open_joint(s, &r);
    must_fail(replay_run(&r, &(duet_tune_def){.strategy = "balance"}, NULL, &o, ERR),
              DUET_STATUS_BAD_ARGUMENT,
              "'balance' chooses a share alone; expected one for kernels");
    replay_close(&r);
    open_surface(recorded, 20000, &r);
    must_fail(replay_run(&r, &(duet_tune_def){.strategy = "random"}, NULL, &o, ERR),
              DUET_STATUS_BAD_ARGUMENT, "'random' chooses kernels and share; expected one for a");
    replay_close(&r);
}

TEST(the_same_seed_gives_the_same_tuning)
{
    replay r;
    open_surface(recorded, 20000, &r);
    for (uint32_t i = 0; strategies[i] && strategies[i] != &strategy_lua; ++i) {
        const char *name = strategies[i]->name;
        replay_outcome first = run(&r, name, 7), other = run(&r, name, 8), again = run(&r, name, 7);
        assert_memory_equal(&first, &again, sizeof first);
        assert_true(first.seconds != other.seconds);
    }
    replay_close(&r);
}

static double median_loss(replay *r, const char *name)
{
    enum { RUNS = 51 };
    double losses[RUNS];
    for (uint64_t seed = 0; seed < RUNS; ++seed)
        losses[seed] = run(r, name, seed).loss;
    qsort(losses, RUNS, sizeof *losses, compare_double);
    return losses[RUNS / 2];
}

// The recorded times have noise of some percent, and the best of a hundred medians is a lucky one.
TEST(on_recorded_surfaces_grid_and_balance_come_near_the_best)
{
    static const uint64_t sizes[] = {20000, 100000};
    for (int i = 0; i < 2; ++i) {
        replay r;
        open_surface(recorded, sizes[i], &r);
        assert_true(r.best->plan.share > 0 && r.best->plan.share < DUET_SHARE_ONE);
        assert_true(median_loss(&r, "grid") < 0.05);
        assert_true(median_loss(&r, "balance") < 0.05);
        replay_close(&r);
    }
}

TEST_BEGIN(open_store)
