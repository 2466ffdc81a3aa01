// SPDX-License-Identifier: MIT
// The whole tuning on devices that are only arithmetic.
#define _GNU_SOURCE
#include "support/test.h"

#include "base/budget.h"
#include "support/recorded.h"
#include "support/simulated_pair.h"
#include "support/store.h"
#include "tuner/trial_budget.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RIGHT = 4711 };

// A simulated pair behind the face of a machine, and what is asked of its tuning. Variant "slow"
// takes thrice the time, "close" a twentieth more, "wrong" finds other pairs, "broken" does not
// build.
typedef struct fake {
    simulated_pair model;
    rng random;
    const char *variants[4]; // none: "auto"
    duet_mode modes[2];
    uint32_t n_modes;
    const char *strategy; // NULL: balance
    const char *usual;    // kernels of the default plan; NULL: "auto"
    const char *usual_b;  // those of B; NULL: the same
    uint32_t fair, start; // as of a problem
    duet_mode fair_mode;
    bool one_device;
    struct fake *whole; // what both are parts of
    double wait_seconds, budget_seconds;
    uint32_t more_trials; // than the least budget, and 1; 0: no budget
    duet_tune_outcome got;
    uint32_t budget_trials;
    double slowness; // slowness of a device whose memory somebody else uses, for a while; 0: none
    bool slow[2];
    bool modes_tie; // else mode shared costs more
    double factor;  // on all times; 0: 1
    double staging; // how many times as long a launch takes whose stages are timed; 0: 1
    uint32_t launches;
    uint32_t staged;     // launches timed by stages
    uint32_t stop_after; // trials; 0: never
    uint32_t recorded;
    record *record;       // that keeps the trials; NULL: none does
    const trial_log *log; // a trial's noise follows from how many are in it; NULL: from `random`
    uint64_t seed;        // and from this
    double launch_ms;     // that all of the work is said to take; 0: launches do all of it
    uint32_t part;        // that launches do; 0: all
    uint32_t wholes;      // launches of all of the work, where parts are done
    double start_ms;      // that each launch takes besides
    double penalty;       // of sharing all of the work, which no part tells of; 0: none
    double spent_s;       // by launches
    uint32_t *shared;     // counts launches of all processes; NULL: nobody does
    double disturbed;     // part of the launches that another program disturbs, of the first ones
    bool one_core;        // it is the system that disturbs them, and no other program is there
    uint32_t looks;       // at other programs, after which these are gone
    uint32_t waits;       // that the watch was told of
} fake;

// Slow for some 20 launches, fast for some 30, and each device by itself.
static double slowed(fake *f, int device, double ns)
{
    if (f->slowness > 0 && rng_unit(&f->random) < (f->slow[device] ? 1.0 / 20 : 1.0 / 30))
        f->slow[device] = !f->slow[device];
    return f->slow[device] ? f->slowness * ns : ns;
}

// Both parts on one core take as long as one after the other, and no two such launches differ.
static void disturb(fake *f, const duet_plan *plan, measure_launch *launch)
{
    bool shared = plan->share > 0 && plan->share < DUET_SHARE_ONE;
    launch->use.cpu_ns = (uint64_t)launch->total_ns;
    if ((f->looks == 0 && !f->one_core) || !shared || rng_unit(&f->random) >= f->disturbed)
        return;
    launch->total_ns = launch->a_ns + launch->b_ns;
    launch->use.lost_ns = launch->use.wait_ns = (uint64_t)launch->total_ns / 2;
    launch->use.disturbed = true;
}

static void set_part(void *context, uint32_t part)
{
    ((fake *)context)->part = part;
}

// A start cost comes to each launch, whatever it does.
static void take_part(fake *f, bool shared, measure_launch *launch)
{
    bool all = f->part == 0 || f->part == DUET_SHARE_ONE;
    double part = all ? 1 : (double)f->part / DUET_SHARE_ONE;
    double longer = all && shared && f->penalty > 0 ? f->penalty : 1;
    int64_t *times[] = {&launch->total_ns, &launch->a_ns, &launch->b_ns};
    for (int i = 0; i < 3; ++i)
        *times[i] =
            *times[i] == 0 ? 0 : (int64_t)((double)*times[i] * part * longer + 1e6 * f->start_ms);
    f->wholes += f->part == DUET_SHARE_ONE;
    f->spent_s += (double)launch->total_ns * 1e-9;
}

static core_others look_fake(void *context)
{
    fake *f = context;
    f->looks -= f->looks > 0;
    return (core_others){.cores = f->looks > 0 ? 1 : 0, .of = 2, .is_crowded = f->looks > 0};
}

static double cost_of(const char *variant)
{
    return strcmp(variant, "slow") == 0 ? 3 : strcmp(variant, "close") == 0 ? 1.05 : 1;
}

static bool launch_fake(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                        duet_error *err)
{
    fake *f = context;
    ++f->launches;
    f->staged += staged;
    if (f->shared)
        ++*f->shared;
    if (f->log && staged)
        f->random = rng_seed(f->seed + f->log->played);
    bool a = plan->share > 0, b = plan->share < DUET_SHARE_ONE;
    if ((a && strcmp(plan->variant_a, "broken") == 0) ||
        (b && strcmp(plan->variant_b, "broken") == 0)) {
        if (err) {
            err->status = DUET_STATUS_BUILD_FAILED;
            strcpy(err->text, "broken does not build");
        }
        return false;
    }
    simulated_pair model = f->model;
    model.ratio *= cost_of(plan->variant_a);
    if (plan->mode == DUET_MODE_SHARED && !f->modes_tie)
        model.overhead[0] += 0.2;
    search_sample s = simulated_launch(&model, plan->share, &f->random);
    double slow_b = b ? cost_of(plan->variant_b) : 1;
    launch->a_ns = (int64_t)slowed(f, 0, (double)s.a_ns);
    launch->b_ns = (int64_t)slowed(f, 1, slow_b * (double)s.b_ns);
    double factor = f->factor > 0 ? f->factor : 1;
    factor *= staged && f->staging > 0 ? f->staging : 1;
    launch->a_ns = (int64_t)((double)launch->a_ns * factor);
    launch->b_ns = (int64_t)((double)launch->b_ns * factor);
    launch->total_ns = launch->a_ns > launch->b_ns ? launch->a_ns : launch->b_ns;
    take_part(f, a && b, launch);
    disturb(f, plan, launch);
    bool wrong = (a && strcmp(plan->variant_a, "wrong") == 0) ||
                 (b && strcmp(plan->variant_b, "wrong") == 0);
    launch->terms.cpu1 = round(1e3 * (double)launch->total_ns * 1e-6) / 1e3;
    launch->hash = wrong ? 1 : RIGHT;
    return true;
}

static bool watch_fake(void *context, const duet_tune_progress *progress)
{
    fake *f = context;
    f->waits += progress->waiting != NULL;
    return f->stop_after == 0 || progress->waiting || progress->remembered ||
           progress->trials % f->stop_after != 0;
}

static bool open_fake(void *whole, const char *kernels, measure_machine *machine, duet_plan *plan)
{
    *machine = (measure_machine){.context = whole, .launch = launch_fake, .hash = RIGHT};
    plan_set_variants(plan, kernels);
    plan->share = 0;
    return true;
}

// A def, and the problem that is of it.
typedef struct question {
    duet_tune_def def;
    tune_problem problem;
} question;

static void ask_fake(fake *f, question *q)
{
    f->variants[0] = f->variants[0] ? f->variants[0] : "auto";
    q->def = (duet_tune_def){
        .strategy = f->strategy ? f->strategy : "balance",
        .variants = f->variants,
        .modes = f->modes,
        .n_modes = f->n_modes,
        .repeats = 3,
        .wait_seconds = f->wait_seconds,
        .budget_seconds = f->budget_seconds,
        .watch = watch_fake,
        .watch_context = f,
    };
    while (q->def.n_variants < 4 && f->variants[q->def.n_variants])
        ++q->def.n_variants;
    if (f->more_trials > 0)
        q->def.budget_trials = trial_budget_least(&q->def) + f->more_trials - 1;
    f->budget_trials = q->def.budget_trials;
    q->problem = (tune_problem){
        .def = &q->def,
        .machine = {.context = f,
                    .launch = launch_fake,
                    .hash = RIGHT,
                    .look_at_others = look_fake,
                    .set_part = f->launch_ms > 0 ? set_part : NULL,
                    .launch_ms = f->launch_ms},
        .plan = {.mode = DUET_MODE_OWN},
        .whole = {f->whole, f->whole ? open_fake : NULL},
        .one_device = f->one_device,
        .fair = f->fair,
        .fair_mode = f->fair_mode,
        .start = f->start,
        .least_share = 8,
    };
    plan_set_variants(&q->problem.plan, f->usual ? f->usual : "auto");
    if (f->usual_b)
        strcpy(q->problem.plan.variant_b, f->usual_b);
    if (f->record)
        q->problem.recorder = record_recorder(f->record);
}

static bool run_fake(fake *f, trial_log *log, duet_error *err)
{
    question q;
    ask_fake(f, &q);
    return tune_run(&q.problem, log, &f->got, err);
}

// Keeps what came out of it in f->got, too.
static duet_tune_outcome tune_fake(fake *f)
{
    own(trial_log) log = {0};
    must(run_fake(f, &log, ERR));
    return f->got;
}

// Fails with that line; returns how many trials there were.
static uint32_t fail_fake(fake *f, duet_status status, const char *says)
{
    own(trial_log) log = {0};
    must_fail(run_fake(f, &log, ERR), status, says);
    return log.n;
}

static bool is_called(const fake *f, const char *verdict)
{
    return strcmp(f->got.verdict, verdict) == 0;
}

static bool has_kernels(const fake *f, const char *a, const char *b)
{
    return strcmp(f->got.plan.variant_a, a) == 0 && strcmp(f->got.plan.variant_b, b) == 0;
}

// How far the chosen share is from another.
static double off_share(const fake *f, double share)
{
    return fabs(f->got.plan.share / 65536.0 - share);
}

// Two halves of a device that differ by so much, and with times that vary.
#define HALVES(overheads, sigmas)                                       \
    {                                                                   \
        .ratio = 1, .overhead = {overheads, overheads}, .sigma = sigmas \
    }
#define NOISY(sigmas, ...)                                                    \
    {                                                                         \
        .sigma = sigmas, .spike_chance = 0.25, .spike_most = 1.6, __VA_ARGS__ \
    }

// Says that both devices are equal, and starts there.
#define EQUAL .fair = DUET_SHARE_ONE / 2, .start = DUET_SHARE_ONE / 2, .fair_mode = DUET_MODE_SLAB

TEST(two_equal_halves_are_shared_evenly_and_gain)
{
    fake f = {.model = HALVES(0.02, 0.02), .random = rng_seed(test_seed())};
    duet_tune_outcome outcome = tune_fake(&f);
    assert_true(is_called(&f, "faster") && off_share(&f, 0.5) < 0.05);
    assert_int_not_equal(outcome.plan.mode, DUET_MODE_SHARED); // which costs more
    assert_true(outcome.gain > 0.6 && outcome.gain_low > 0.6 && outcome.gain_high < 1.1);
    assert_int_equal(outcome.launches, f.launches);
}

// Timing a GPU's stages makes its launches longer.
TEST(what_counts_is_launched_as_applications_launch_it)
{
    fake f = {.model = HALVES(0.02, 0), .random = rng_seed(test_seed()), .staging = 3};
    duet_tune_outcome outcome = tune_fake(&f);
    assert_true(outcome.trials > 0 && f.launches > 2 * outcome.trials);
    assert_int_equal(f.staged, outcome.trials); // to warm up
    double alone_ms = (double)simulated_launch(&f.model, 0, NULL).total_ns * 1e-6;
    double step_ms = (double)simulated_launch(&f.model, outcome.plan.share, NULL).total_ns * 1e-6;
    assert_true(fabs(outcome.single_ms - alone_ms) < 1e-3 * alone_ms);
    assert_true(fabs(outcome.step_ms - step_ms) < 1e-3 * step_ms);
}

// Each device takes as long for any part of the work.
static const simulated_row flat_rows[] = {
    {.share = 0, .a_ns = 10000000, .b_ns = 10000000},
    {.share = SEARCH_ONE, .a_ns = 10000000, .b_ns = 10000000},
};

// Tunes `like` so many times, and returns how often it is as it should be.
static int count(int times, fake like, bool (*is_right)(const fake *f))
{
    int right = 0;
    like.random = rng_seed(test_seed());
    for (int i = 0; i < times; ++i) {
        fake f = like;
        tune_fake(&f);
        right += is_right(&f);
        like.random = f.random;
    }
    print_message("%d of %d\n", right, times);
    return right;
}

static int n_gaining; // 60 %

static bool is_shared_evenly(const fake *f)
{
    n_gaining += f->got.gain >= 0.6;
    return off_share(f, 0.5) < 0.05;
}

// Acts like a machine whose last cache other programs use: a device takes 1.45 times
// as long for a while, now one, now the other, alone as together; and every fourth
// launch something takes its core away. Divided evenly a step takes 1 / 1.9 of a
// single device's in three rounds of four.
//
// While one device is slow the share that ends both together is .59, so that not every tuning ends
// near .5: 90.7 % of 20 000 do in 100 seeds, and 87.6 % gain so much. Of 1 000 the parts below are
// four deviations less.
TEST(devices_that_are_slow_for_a_while_hide_neither_share_nor_gain)
{
    enum { TIMES = 1000 };
    const fake f = {.model = NOISY(0.02, .ratio = 1, .overhead = {0.03, 0.03}), .slowness = 1.45};
    assert_true(count(TIMES, f, is_shared_evenly) >= 0.87 * TIMES);
    print_message("%d gains of 60 %%\n", n_gaining);
    assert_true(n_gaining >= 0.83 * TIMES);
}

static bool is_shared_fairly_and_faster(const fake *f)
{
    return is_called(f, "faster") && off_share(f, 0.5) <= 0.03;
}

// Times that vary by 15 % lead a search to shares from .4 to .6.
TEST(equal_devices_share_fairly_on_a_noisy_machine)
{
    enum { TIMES = 200 };
    const fake f = {
        .model = NOISY(0.15, .ratio = 1, .overhead = {0.03, 0.03}), .slowness = 1.2, EQUAL};
    assert_true(count(TIMES, f, is_shared_fairly_and_faster) >= 0.98 * TIMES);
}

static bool has_slower_kernels(const fake *f)
{
    return !has_kernels(f, "auto", "auto");
}

// In few noisy launches the slower one of two kernels often leads.
TEST(equal_devices_keep_the_default_kernels_unless_others_are_proven_faster)
{
    enum { TIMES = 200 };
    const fake f = {.model = NOISY(0.1, .ratio = 1, .overhead = {0.03, 0.03}),
                    .variants = {"close", "auto"},
                    EQUAL};
    assert_true(count(TIMES, f, has_slower_kernels) <= 0.02 * TIMES);
}

// And take those that are.
TEST(equal_devices_take_kernels_that_are_faster)
{
    fake f = {.model = HALVES(0, 0.05),
              .random = rng_seed(test_seed()),
              .variants = {"slow", "close"},
              .usual = "slow",
              EQUAL};
    f.fair_mode = DUET_MODE_OWN;
    tune_fake(&f);
    assert_true(has_kernels(&f, "close", "close") && is_called(&f, "faster"));
}

static bool is_near_the_best(const fake *f)
{
    return simulated_excess(&f->model, f->got.plan.share) < 0.06;
}

// Two devices of one name, one of which is hot.
TEST(devices_that_only_look_equal_are_told_apart)
{
    const fake f = {.model = {.ratio = 1.5, .overhead = {0.02, 0.02}, .sigma = 0.03}, EQUAL};
    assert_int_equal(count(50, f, is_near_the_best), 50);
}

// The system keeps both parts on one core, and no other program is there to wait for.
TEST(parts_on_one_core_are_not_said_to_be_the_same)
{
    fake f = {.model = HALVES(0.02, 0.02),
              .random = rng_seed(test_seed()),
              .disturbed = 0.9,
              .one_core = true,
              .wait_seconds = 1};
    assert_string_equal(tune_fake(&f).unused, "both parts were on one core");
    assert_true(is_called(&f, "ambiguous"));
}

static bool is_ambiguous(const fake *f)
{
    const duet_tune_outcome *got = &f->got;
    bool ambiguous = is_called(f, "ambiguous");
    if (is_called(f, "same") && (f->disturbed > 0.1 || f->fair))
        assert_true(got->gain_high < 0.1001 && got->gain_low > 1 / 1.1001 - 1);
    assert_true(ambiguous == (strncmp(got->unused, "times vary too much: ", 21) == 0));
    return ambiguous;
}

// A race of times that differ by up to four times cannot show that sharing gains nothing.
static int count_ambiguous(double disturbed, uint32_t fair, double overhead)
{
    return count(100,
                 (fake){.model = {.ratio = 1,
                                  .overhead = {overhead, overhead},
                                  .sigma = 0.05,
                                  .spike_chance = 0.5,
                                  .spike_most = 4},
                        .disturbed = disturbed,
                        .one_core = true,
                        .wait_seconds = 1,
                        .fair = fair},
                 is_ambiguous);
}

TEST(doubt_chooses_no_single_device_where_sharing_is_expected_to_gain)
{
    static const double overheads[] = {0, 0.1, 0.55}; // 0.5: sharing gains nothing
    for (int i = 0; i < 3; ++i) {
        print_message("overhead %.2f, beside disturbed launches, and of equal devices:\n",
                      overheads[i]);
        int with_waits = count_ambiguous(0.4, 0, overheads[i]);
        int equal = count_ambiguous(0, DUET_SHARE_ONE / 2, overheads[i]);
        assert_true(overheads[i] > 0.5 || (equal > 0 && with_waits > 0));
        assert_int_equal(count_ambiguous(0, 0, overheads[i]), 0);
    }
}

static bool is_best_in_slabs(const fake *f)
{
    return f->got.best.mode == DUET_MODE_SLAB;
}

TEST(equal_devices_keep_the_default_mode_unless_another_is_proven_faster)
{
    const fake f = {.model = NOISY(0.15, .ratio = 1),
                    .modes = {DUET_MODE_OWN, DUET_MODE_SLAB},
                    .n_modes = 2,
                    EQUAL};
    assert_true(count(200, f, is_best_in_slabs) >= 190);
}

static bool is_the_same(const fake *f)
{
    return is_called(f, "same");
}

// The best of several plans that are all the same is one more of them, however
// fast it looked when it was chosen.
TEST(sharing_that_changes_nothing_is_called_the_same)
{
    enum { TIMES = 500 };
    const fake f = {.model = {.sigma = 0.03,
                              .spike_chance = 0.05,
                              .spike_most = 3,
                              .rows = flat_rows,
                              .n_rows = 2},
                    .modes_tie = true};
    assert_true(count(TIMES, f, is_the_same) >= 0.97 * TIMES);
}

static uint64_t tie_launches;

static bool is_raced(const fake *f)
{
    tie_launches += f->launches;
    return is_called(f, "faster") && simulated_excess(&f->model, f->got.plan.share) < 0.02;
}

// The rest of a race once it no longer matters who wins is not run.
TEST(modes_that_tie_are_not_raced_to_the_end)
{
    enum { TIMES = 50 };
    const fake f = {.model = HALVES(0, 0.01), .modes_tie = true};
    assert_int_equal(count(TIMES, f, is_raced), TIMES);
    print_message("%.0f launches each\n", (double)tie_launches / TIMES);
    assert_true(tie_launches < 330 * TIMES); // 418 each in full races
}

TEST(sharing_that_only_costs_chooses_the_better_single_device)
{
    static const double ratios[] = {20, 0.05};
    for (int i = 0; i < 2; ++i) {
        double best = ratios[i] / (ratios[i] + 1);
        fake f = {
            .model = {.ratio = ratios[i], .overhead = {0.4 * best, 0.4 * best}, .sigma = 0.02},
            .random = rng_seed(test_seed())};
        assert_int_equal(tune_fake(&f).plan.share, i == 0 ? 0 : DUET_SHARE_ONE);
        assert_false(is_called(&f, "faster"));
    }
}

TEST(the_tuned_plan_is_never_slower_than_a_single_device)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 200; ++i) {
        fake f = {.model = simulated_invent((simulated_family)(i % 3), i % 2, &r), .random = r};
        f.model.sigma = 0.03;
        f.model.spike_chance = 0.03;
        f.model.spike_most = 3;
        uint32_t share = tune_fake(&f).plan.share;
        double single = fmin((double)simulated_launch(&f.model, 0, NULL).total_ns,
                             (double)simulated_launch(&f.model, SEARCH_ONE, NULL).total_ns);
        assert_true((double)simulated_launch(&f.model, share, NULL).total_ns <= 1.01 * single);
    }
}

// Devices that share one memory slow each other, so that a part takes A up to three times as long
// as it would by itself: what A took for its parts does not say that B alone is the better one.
TEST(a_device_that_sharing_slows_down_is_tried_alone)
{
    enum { TIMES = 300 };
    int a_alone = 0;
    rng r = rng_seed(test_seed());
    for (int i = 0; i < TIMES; ++i) {
        double ratio = pow(8, rng_between(&r, -0.5, 0.5)), slowed = rng_between(&r, 0, 2);
        fake f = {.model = {.ratio = ratio, .interference = slowed, .sigma = 0.01}, .random = r};
        uint32_t share = tune_fake(&f).plan.share;
        double ns = (double)simulated_launch(&f.model, share, NULL).total_ns;
        assert_true(ns <= 1.02e7 * fmin(ratio, 1));
        a_alone += share == DUET_SHARE_ONE;
        r = f.random;
    }
    print_message("A alone in %d\n", a_alone);
    assert_true(a_alone > TIMES / 8);
}

TEST(each_device_gets_its_best_variant)
{
    fake f = {.model = {.ratio = 4, .sigma = 0.02},
              .random = rng_seed(test_seed()),
              .variants = {"slow", "broken", "auto", "wrong"}};
    tune_fake(&f);
    assert_true(has_kernels(&f, "auto", "auto") && off_share(&f, 0.2) < 0.03);
}

TEST(a_default_that_finds_wrong_pairs_ends_the_tuning)
{
    fake f = {.model = {.ratio = 4}, .variants = {"wrong"}, .usual = "wrong"};
    fail_fake(&f, DUET_STATUS_WRONG_RESULT, "result hash 0000000000000001");
    assert_int_equal(f.launches, 1);
}

TEST(nothing_that_builds_is_said_with_its_reason)
{
    fake f = {.model = {.ratio = 4}, .variants = {"broken"}};
    fail_fake(&f, DUET_STATUS_BUILD_FAILED, "broken does not build");
}

static void assert_same(const duet_tune_outcome *a, const duet_tune_outcome *b)
{
    assert_int_equal(a->plan.share, b->plan.share);
    assert_int_equal(a->best.share, b->best.share);
    assert_true(a->gain == b->gain && a->gain_low == b->gain_low);
    assert_string_equal(a->verdict, b->verdict);
    assert_int_equal(a->launches, b->launches);
    assert_true(a->terms.cpu1 > 0 && a->terms.cpu1 == b->terms.cpu1);
}

// Stopped after every few trials, and taken up from the store each time; the races with the
// undivided device, too.
TEST(a_resumed_tuning_ends_as_an_uninterrupted_one)
{
    uint64_t seed = test_seed();
    fake undivided = {.model = HALVES(0, 0.02), .random = rng_seed(seed)}, again;
    fake whole = {.model = {.ratio = 1.5, .overhead = {0.1, 0.05}, .sigma = 0.04},
                  .random = rng_seed(seed),
                  .whole = &again};
    again = undivided;
    tune_fake(&whole);
    uint32_t launches = again.launches;
    for (uint32_t stop = 1; stop <= 7; stop += 3) {
        record r = test_record(test_store_fresh());
        fake f = {.model = whole.model,
                  .random = rng_seed(seed),
                  .stop_after = stop,
                  .whole = &again,
                  .record = &r};
        own(trial_log) kept = {0};
        duet_error err = {0};
        uint32_t stops = 0;
        again = undivided;
        while (!run_fake(&f, &kept, &err)) {
            assert_int_equal(err.status, DUET_STATUS_INTERRUPTED);
            err = (duet_error){0};
            test_record_again(&r, &kept);
            assert_true(++stops < 500);
        }
        assert_same(&f.got, &whole.got);
        assert_true(f.got.whole_gain_low == whole.got.whole_gain_low);
        assert_true(launches > 0 && again.launches == launches);
        assert_int_equal(f.launches, whole.launches);
    }
}

// ---------------------------------------------------------------- long launches

// Launches of 10 s by one device.
static fake long_ones(uint64_t seed, double ratio, double start_ms)
{
    return (fake){.model = {.ratio = ratio, .sigma = 0.02},
                  .random = rng_seed(seed),
                  .factor = 1000,
                  .launch_ms = 5000,
                  .start_ms = start_ms};
}

TEST(long_launches_are_compared_on_a_part_of_the_items)
{
    static const double starts[] = {0, 0.5, 10};
    uint64_t seed = test_seed();
    for (int i = 0; i < 9; ++i) {
        double ratio = (double[]){1, 1.7, 4}[i % 3];
        fake f = long_ones(seed + (uint64_t)i, ratio, starts[i / 3]);
        duet_tune_outcome o = tune_fake(&f);
        double best_ms = 1e4 * ratio / (1 + ratio);
        assert_true(is_called(&f, "faster"));
        assert_true(simulated_excess(&f.model, o.plan.share) < 0.03);
        assert_true(fabs(o.step_ms / best_ms - 1) < 0.1 && fabs(o.single_ms / 1e4 - 1) < 0.1);
        assert_true(o.step_low_ms < o.step_ms && o.step_ms < o.step_high_ms);
        assert_in_range(f.wholes, 2, 8);
        print_message("ratio %.1f, start %.1f ms: %u launches, %.1f s\n", ratio, starts[i / 3],
                      f.launches, f.spent_s);
        assert_true(f.spent_s < 0.1 * f.launches * 1e-3 * best_ms); // than if all did all items
    }
}

// The part grows until a start cost is small beside it.
TEST(a_part_is_as_large_as_a_start_needs)
{
    fake f = long_ones(test_seed(), 1, 0);
    own(trial_log) none = {0}, some = {0};
    f.model.sigma = 0;
    must(run_fake(&f, &none, ERR));
    f.start_ms = 20;
    must(run_fake(&f, &some, ERR));
    int32_t without = none.entries[none.n / 2].scope, with = some.entries[some.n / 2].scope;
    assert_in_range(without, DUET_SHARE_ONE / 512, DUET_SHARE_ONE / 128);
    assert_in_range(with, 4 * without, 16 * without);
    assert_int_equal(some.entries[some.n - 1].scope, DUET_SHARE_ONE);
}

// By any part sharing is nearly twice as fast.
TEST(a_part_that_misleads_is_found_out)
{
    fake f = long_ones(test_seed(), 1, 0);
    f.penalty = 3;
    duet_tune_outcome o = tune_fake(&f);
    assert_false(is_called(&f, "faster"));
    assert_true(o.plan.share == 0 || o.plan.share == DUET_SHARE_ONE);
    assert_true(o.gain_high < 0 && fabs(o.step_ms / 1e4 - 1) < 0.1);
}

TEST(a_long_tuning_that_is_taken_up_goes_on_with_its_part)
{
    fake f = long_ones(test_seed(), 1.7, 0.5);
    f.model.sigma = 0;
    fake whole = f;
    tune_fake(&whole);
    record r = test_record(test_store_fresh());
    f.record = &r;
    f.stop_after = 3;
    own(trial_log) kept = {0};
    duet_error err = {0};
    while (!run_fake(&f, &kept, &err)) {
        assert_int_equal(err.status, DUET_STATUS_INTERRUPTED);
        err = (duet_error){0};
        f.launch_ms *= 0.8; // another estimate
        test_record_again(&r, &kept);
    }
    assert_int_equal(f.got.plan.share, whole.got.plan.share);
    assert_int_equal(f.got.trials, whole.got.trials);
    assert_string_equal(f.got.verdict, whole.got.verdict);
}

// ---------------------------------------------------------------- kills

static void tune_in_a_process(fake *f, const char *path)
{
    duet_error err = {0};
    own(trial_log) log = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    record r = test_record(s);
    f->record = &r;
    f->log = &log;
    bool ok = record_recall(&r, &log, &err) && run_fake(f, &log, &err);
    store_close(s);
    fprintf(stderr, "%s", err.text);
    _exit(ok ? 0 : 1);
}

// Killed at any moment, again and again: no more is lost each time than the trial at hand.
TEST(a_killed_tuning_goes_on_from_what_it_has_stored)
{
    enum { A_TRIAL = 4 }; // launches
    test_folder folder = test_folder_make();
    rng r = rng_seed(test_seed());
    const fake f = {.model = {.ratio = 6, .overhead = {0.1, 0.05}, .sigma = 0.04},
                    .seed = test_seed()};
    fake whole = f, last = f;
    own(trial_log) log = {0}, stored = {0};
    whole.log = &log;
    must(run_fake(&whole, &log, ERR));
    last.shared =
        mmap(NULL, sizeof *last.shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_true(last.shared != MAP_FAILED);
    store_close(test_store_open(folder.store, STORE_WRITE));
    int status, kills = 0;
    do {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            tune_in_a_process(&last, folder.store);
        usleep(rng_below(&r, 9000) * (uint32_t)(1 + kills / 20)); // a slow machine gets there too
        kill(child, SIGKILL);
        assert_int_equal(waitpid(child, &status, 0), child);
        kills += WIFSIGNALED(status) != 0;
    } while (WIFSIGNALED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    print_message("killed %d times, %u launches of %u\n", kills, *last.shared, whole.launches);
    assert_in_range(*last.shared, whole.launches, whole.launches + A_TRIAL * (uint32_t)kills);
    record kept = test_record(test_store_open(folder.store, STORE_WRITE));
    test_record_again(&kept, &stored);
    uint32_t before = last.launches;
    must(run_fake(&last, &stored, ERR));
    assert_int_equal(last.launches, before); // all of it was stored
    assert_same(&last.got, &whole.got);
    store_close(kept.store);
    munmap(last.shared, sizeof *last.shared);
}

// Whatever is chosen from, from the least budget on.
TEST(a_budget_ends_the_search_and_leaves_room_for_a_verdict)
{
    static const char *const searches[] = {"balance", "fig12", "grid"};
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < 2000; ++i) {
        fake whole = {.model = {.ratio = 1}};
        fake f = {.model = {.ratio = 0.3 + 4 * rng_unit(&r), .sigma = 0.03},
                  .strategy = searches[i % 3],
                  .variants = {"auto", i % 2 ? "slow" : NULL, "slow"},
                  .modes = {DUET_MODE_OWN, DUET_MODE_SLAB},
                  .n_modes = i / 2 % 3,
                  .more_trials = 1 + i % 20,
                  .whole = i % 5 ? NULL : &whole};
        f.random = whole.random = r;
        duet_tune_outcome outcome = tune_fake(&f);
        assert_false(is_called(&f, "ambiguous"));
        assert_in_range(outcome.rounds, 8, 40);
        assert_in_range(outcome.trials, 10, f.budget_trials);
        assert_true(outcome.step_ms > 0);
        assert_int_equal(outcome.whole_ms > 0, i % 5 == 0);
        r = f.random;
    }
}

// A step takes 10 ms alone.
TEST(seconds_that_cannot_do_are_refused_after_the_first_trial)
{
    fake f = {.model = {.ratio = 3}, .budget_seconds = 1e-3};
    assert_int_equal(
        fail_fake(&f, DUET_STATUS_BAD_ARGUMENT, "a budget of 0.001 s ends before a verdict"), 1);
}

// ---------------------------------------------------------------- parts of one device

TEST(parts_are_raced_against_the_undivided_device)
{
    rng r = rng_seed(test_seed());
    static const double slower[] = {0.25, 4}; // than A and B: both times of the whole
    for (int i = 0; i < 2; ++i) {
        fake whole = {.model = HALVES(0, 0.02), .random = r, .factor = slower[i]};
        fake f = {.model = HALVES(0, 0.02), .random = r, .whole = &whole};
        duet_tune_outcome outcome = tune_fake(&f);
        assert_true(is_called(&f, "faster"));
        assert_true(i == 0 ? outcome.whole_gain_high < 0 : outcome.whole_gain_low > 0);
        assert_true(fabs((1 + outcome.whole_gain) * outcome.step_ms - outcome.whole_ms) <
                    0.1 * outcome.whole_ms);
        assert_int_equal(outcome.launches, f.launches + whole.launches);
        assert_in_range(whole.launches, 8, 80);
        f.whole = NULL;
        assert_true(isnan(tune_fake(&f).whole_ms));
    }
}

TEST(one_device_gets_its_best_kernels_and_no_share)
{
    fake f = {.model = HALVES(0, 0.02),
              .random = rng_seed(test_seed()),
              .variants = {"slow", "auto"},
              .one_device = true};
    duet_tune_outcome outcome = tune_fake(&f);
    assert_int_equal(outcome.plan.share, 0);
    assert_true(has_kernels(&f, "auto", "auto") && is_called(&f, "same"));
    assert_true(outcome.gain == 0 && outcome.step_low_ms < outcome.step_high_ms);
    assert_in_range(f.launches, 20, 100);
    f.usual_b = "slow";
    assert_string_equal(tune_fake(&f).plan.variant_b, "auto");
}

static bool left_the_usual_kernels(const fake *f)
{
    return strcmp(f->got.plan.variant_b, "auto") != 0;
}

// Luck in a quick race is no reason to leave the usual kernels.
TEST(one_device_keeps_its_usual_kernels_unless_others_are_surely_faster)
{
    enum { TIMES = 200 };
    const fake f = {
        .model = HALVES(0, 0.1), .variants = {"auto", "other", "another"}, .one_device = true};
    assert_in_range(count(TIMES, f, left_the_usual_kernels), 0, 0.03 * TIMES);
}

// However long its kernels race.
TEST(a_budget_leaves_an_only_device_its_time)
{
    fake f = {.model = HALVES(0, 0.2),
              .random = rng_seed(test_seed()),
              .variants = {"auto", "other"},
              .one_device = true};
    for (uint32_t i = 0; i < 50; ++i) {
        f.more_trials = 1 + i % 40;
        duet_tune_outcome outcome = tune_fake(&f);
        assert_in_range(outcome.trials, 8, f.budget_trials);
        assert_true(outcome.step_low_ms > 0 && outcome.step_low_ms < outcome.step_high_ms);
    }
}

// ---------------------------------------------------------------- Ctrl-C

static bool stopped_now;

static bool is_stopped(void)
{
    return stopped_now;
}

// Does as Ctrl-C at a terminal, which reaches the driver's compiler too.
static bool launch_stopped(void *context, const duet_plan *plan, bool staged,
                           measure_launch *launch, duet_error *err)
{
    fake *f = context;
    if (f->launches == 10) {
        stopped_now = true;
        return error_set(err, DUET_STATUS_BUILD_FAILED, "the linker was killed");
    }
    return launch_fake(context, plan, staged, launch, err);
}

static bool count_recorded(void *context, uint32_t number, const measurement *m, duet_error *err)
{
    (void)number;
    (void)m;
    (void)err;
    ++((fake *)context)->recorded;
    return true;
}

TEST(a_stop_while_a_kernel_is_built_is_no_trial)
{
    static budget_watch stops = {.stopped = is_stopped};
    fake f = {.model = {.ratio = 3}};
    question q;
    ask_fake(&f, &q);
    q.problem.machine.launch = launch_stopped;
    q.problem.recorder = (tune_recorder){&f, count_recorded};
    own(trial_log) kept = {0};
    duet_error err = {0};
    stopped_now = false;
    budget_set_watch(&stops);
    bool ran = tune_run(&q.problem, &kept, &f.got, &err);
    budget_set_watch(NULL);
    assert_false(ran);
    assert_int_equal(err.status, DUET_STATUS_INTERRUPTED);
    assert_says(err.text, "stopped after 2 trials");
    assert_int_equal(kept.n, 2); // trials of four launches each; the third was cut
    assert_int_equal(f.recorded, 2);
}

TEST(a_start_from_a_neighbour_saves_trials)
{
    fake f = {.model = {.ratio = 9, .overhead = {0.05, 0.05}}, .start = SEARCH_ONE / 10};
    own(trial_log) kept = {0};
    must(run_fake(&f, &kept, ERR));
    assert_int_equal(kept.entries[1].plan.share, SEARCH_ONE / 10);
}

TEST(a_log_of_another_tuning_is_forgotten_where_it_differs)
{
    store *s = test_store_fresh();
    record r = test_record(s);
    fake f = {.model = {.ratio = 3, .sigma = 0.02}, .random = rng_seed(test_seed()), .record = &r};
    own(trial_log) kept = {0};
    must(run_fake(&f, &kept, ERR));
    assert_int_equal(test_count(s, "trial"), f.got.trials);
    kept.entries[2].plan.share += 5;
    uint32_t known = kept.entries[0].launches + kept.entries[1].launches;
    uint32_t before = f.launches;
    must(run_fake(&f, &kept, ERR));
    assert_int_equal(f.launches - before, f.got.launches - known);
    assert_int_equal(test_count(s, "trial"), f.got.trials);
    test_record_again(&r, &kept);
    before = f.launches;
    must(run_fake(&f, &kept, ERR));
    assert_int_equal(f.launches, before);
}

static fake halves(uint64_t seed, double disturbed, uint32_t looks, double wait_seconds)
{
    return (fake){.model = HALVES(0, 0.01),
                  .random = rng_seed(seed),
                  .disturbed = disturbed,
                  .looks = looks,
                  .wait_seconds = wait_seconds};
}

// Times of a disturbed launch are narrow and wrong: repeated ones must not count.
TEST(launches_that_other_programs_disturb_do_not_count)
{
    uint64_t seed = test_seed();
    fake f = halves(seed, 0.6, UINT32_MAX, 1e6);
    duet_tune_outcome outcome = tune_fake(&f);
    assert_true(is_called(&f, "faster"));
    assert_in_range(outcome.plan.share, DUET_SHARE_ONE * 47 / 100, DUET_SHARE_ONE * 53 / 100);
    assert_true(outcome.disturbed > 0 && outcome.disturbed < outcome.watched);
    // Unchanged, they hide what sharing gains.
    f = halves(seed, 1, UINT32_MAX, 0);
    tune_fake(&f);
    assert_false(is_called(&f, "faster"));
}

TEST(a_tuning_waits_until_other_programs_are_gone)
{
    fake f = halves(test_seed(), 1, 4, 1e6);
    assert_true(tune_fake(&f).disturbed > 0 && is_called(&f, "faster"));
    assert_in_range(f.waits, 1, 4);
}

TEST(a_tuning_that_waited_in_vain_is_ambiguous_and_goes_on_later)
{
    fake f = halves(test_seed(), 1, UINT32_MAX, 0.25);
    own(trial_log) log = {0};
    must(run_fake(&f, &log, ERR));
    assert_true(tune_gave_up(&f.got) && is_called(&f, "ambiguous"));
    assert_string_equal(f.got.unused, "other programs had 1.0 of 2 cores");
    assert_true(f.waits > 0);
    uint32_t kept = log.n;
    for (uint32_t i = 0; i < kept; ++i)
        assert_true(log.entries[i].plan.share == 0 || log.entries[i].plan.share == DUET_SHARE_ONE);
    f.looks = 0;
    must(run_fake(&f, &log, ERR));
    assert_true(is_called(&f, "faster") && log.n > kept);
}

// The machine is then as quiet as it can be: its threads are in each other's way.
TEST(launches_that_no_other_program_disturbs_count_in_the_end)
{
    fake f = halves(test_seed(), 1, UINT32_MAX, 1e6);
    question q;
    own(trial_log) log = {0};
    ask_fake(&f, &q);
    q.problem.machine.look_at_others = NULL;
    must(tune_run(&q.problem, &log, &f.got, ERR));
    assert_false(is_called(&f, "faster") || tune_gave_up(&f.got));
    assert_int_equal(f.waits, 0);
}

TEST(a_measurement_keeps_the_warm_up_and_marks_outliers)
{
    fake f = {.model = {.ratio = 3, .sigma = 0.01, .spike_chance = 0.2, .spike_most = 9},
              .random = rng_seed(test_seed())};
    measure_machine machine = {.context = &f, .launch = launch_fake, .hash = RIGHT};
    duet_plan plan = {.share = 16384, .variant_a = "auto", .variant_b = "auto"};
    measurement m = measure_plan(&machine, &plan, (measure_way){.repeats = 20});
    assert_string_equal(m.row.outcome, "ok");
    assert_int_equal(m.n_samples, 21);
    assert_int_equal(m.samples[0].flags, PROFILE_SAMPLE_WARM_UP);
    uint32_t marked = 0;
    for (uint32_t i = 1; i < m.n_samples; ++i)
        marked += m.samples[i].flags == PROFILE_SAMPLE_OUTLIER;
    assert_int_equal(marked, m.row.outliers);
    assert_true(m.row.outliers > 0);
    assert_true(m.row.low_ns <= m.row.median_ns && m.row.median_ns <= m.row.high_ns);
    assert_true((double)m.samples[m.typical].total_ns <= m.row.median_ns);
}
