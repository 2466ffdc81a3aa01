// SPDX-License-Identifier: MIT
// Tunings that make energy small, on two devices that are only arithmetic.
#include "support/test.h"

#include "support/recorded.h"
#include "support/store.h"

#define FILE_NAME "test_energy.txt"

// A takes four times as long as B, and a tenth of its power; the rest of the machine takes power as
// long as the step lasts.
enum { A_MS = 40, B_MS = 10, A_WATTS = 20, B_WATTS = 200, REST_WATTS = 10, SLOW_MS = 100 };

static double joules;  // so far
static double told_ms; // and then the counter moves; 0: after each step
static double now_ms;
static double sigma; // of a step's energy
static rng random_of;
static record *kept_in; // NULL: nowhere

static double step_ms(double share)
{
    return fmax(A_MS * share, B_MS * (1 - share));
}

static double step_joules(double share)
{
    return 1e-3 *
           (A_WATTS * A_MS * share + B_WATTS * B_MS * (1 - share) + REST_WATTS * step_ms(share));
}

static bool launch(void *context, const duet_plan *plan, bool staged, measure_launch *out,
                   duet_error *err)
{
    double share = plan->share / 65536.0;
    char now[40];
    (void)context, (void)staged, (void)err;
    joules += step_joules(share) * (1 + sigma * rng_normal(&random_of));
    now_ms += step_ms(share);
    if (now_ms >= told_ms) {
        snprintf(now, sizeof now, "%.12f J\n", joules);
        test_write_file(FILE_NAME, now);
        told_ms += told_ms > 0 ? SLOW_MS * ceil((now_ms + 1e-9 - told_ms) / SLOW_MS) : 0;
    }
    out->a_ns = (int64_t)(1e6 * A_MS * share);
    out->b_ns = (int64_t)(1e6 * B_MS * (1 - share));
    out->total_ns = (int64_t)(1e6 * step_ms(share));
    return true;
}

static duet_tune_outcome tune(const char *name, energy_meter *meter, trial_log *log)
{
    static const char *const one[] = {"auto"};
    static const duet_mode modes[] = {DUET_MODE_OWN};
    const duet_tune_def def = {.strategy = name,
                               .variants = one,
                               .n_variants = 1,
                               .modes = modes,
                               .n_modes = 1,
                               .repeats = 2};
    const tune_problem problem = {
        .def = &def,
        .recorder = kept_in ? record_recorder(kept_in) : (tune_recorder){0},
        .machine = {.launch = launch},
        .meter = meter,
        .plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"},
        .least_share = 8};
    duet_tune_outcome o;
    must(tune_run(&problem, log, &o, ERR));
    return o;
}

static energy_meter *open_meter(void)
{
    const energy_meter_def def = {.file = FILE_NAME};
    test_write_file(FILE_NAME, "0 J\n");
    return must(energy_meter_open(&def, ERR));
}

// By time the best share is 0.2, where both end together. By energy A does all: it takes 0.8 J for
// it where B takes 2, and the longer step costs 0.3 J more.
TEST(energy_and_time_have_best_plans_of_their_own)
{
    own(trial_log) log = {0}, timed = {0};
    energy_meter *m = open_meter();
    duet_tune_outcome quick = tune("balance", NULL, &timed);
    assert_true(fabs(quick.plan.share / 65536.0 - 0.2) < 0.01);
    assert_true(quick.terms.joules == 0 && quick.single_joules == 0);
    duet_tune_outcome o = tune("annealing", m, &log);
    double best = INFINITY;
    for (int point = 0; point <= 16; ++point)
        best = fmin(best, step_joules(point / 16.0));
    assert_true(fabs(step_joules(o.plan.share / 65536.0) / best - 1) < 1e-6);
    assert_int_equal(o.plan.share, DUET_SHARE_ONE);
    assert_true(fabs(o.terms.joules / step_joules(1) - 1) < 1e-6);
    assert_true(fabs(o.step_ms / A_MS - 1) < 1e-6); // its time stays a time
    energy_meter_close(m);
}

// The counter of a GPU moves ten times a second: each plan runs from one move to another, so that
// its energy is known within a launch, and not within a step of the counter.
TEST(a_counter_that_moves_seldom_tells_energies_and_leads_to_a_verdict)
{
    random_of = rng_seed(test_seed());
    sigma = 0.02;
    told_ms = SLOW_MS;
    now_ms = 0;
    energy_meter *m = open_meter();
    const measure_machine machine = {.launch = launch};
    for (int i = 0; i < 40; ++i) {
        duet_plan plan = {.share = rng_below(&random_of, DUET_SHARE_ONE + 1)};
        double share = plan.share / 65536.0;
        measurement found = measure_plan(&machine, &plan, (measure_way){.repeats = 2, .meter = m});
        assert_string_equal(found.row.outcome, "ok");
        double off = found.trial.terms.joules / step_joules(share) - 1;
        // a step at both ends, of 400 ms, and the noise of ten steps or more
        assert_true(fabs(off) < step_ms(share) / 400 + 4 * sigma / sqrt(10));
    }
    own(trial_log) log = {0};
    duet_tune_outcome o = tune("annealing", m, &log);
    assert_int_equal(o.plan.share, DUET_SHARE_ONE);
    assert_string_not_equal(o.verdict, "ambiguous");
    print_message("%u trials\n", o.trials);
    energy_meter_close(m);
    sigma = told_ms = 0;
}

// Each trial's energy is in the log, and comes back from the store.
TEST(each_trial_keeps_its_energy_beside_its_time)
{
    own(trial_log) log = {0}, again = {0};
    energy_meter *m = open_meter();
    record r = test_record(test_store_fresh());
    kept_in = &r;
    tune("grid", m, &log);
    kept_in = NULL;
    test_record_again(&r, &again);
    assert_true(log.n > 30 && again.n == log.n);
    for (uint32_t i = 0; i < log.n; ++i) {
        double share = log.entries[i].plan.share / 65536.0;
        assert_true(fabs(again.entries[i].terms.joules / step_joules(share) - 1) < 1e-6);
        assert_true(fabs((double)again.entries[i].sample.total_ns / (1e6 * step_ms(share)) - 1) <
                    1e-6);
    }
    energy_meter_close(m);
}

static bool launch_nothing(void *context, const duet_plan *plan, bool staged, measure_launch *out,
                           duet_error *err)
{
    (void)context, (void)plan, (void)staged, (void)err;
    out->total_ns = out->b_ns = 1000000;
    return true;
}

TEST(a_counter_that_does_not_move_is_no_energy)
{
    const measure_machine machine = {.launch = launch_nothing};
    energy_meter *m = open_meter();
    measurement found =
        measure_plan(&machine, &(duet_plan){0}, (measure_way){.repeats = 2, .meter = m});
    assert_string_not_equal(found.row.outcome, "ok");
    assert_says(found.failure.text, FILE_NAME " did not move within 2000 launches");
    energy_meter_close(m);
}
