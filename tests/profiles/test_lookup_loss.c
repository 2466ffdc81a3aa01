// SPDX-License-Identifier: MIT
// What a looked-up plan costs beside the default one, for sizes that were never tuned. The truth is
// a model of two devices, which the look-up never sees.
#include "support/test.h"

#include "profiles/sql.h"
#include "support/look.h"

#define LEAST_N 2e3
#define MOST_N 2e6
#define MOST_LOSS 0.03

enum { OWN, SLAB, MODES };
static const char *const mode_names[MODES] = {"own", "slab"};

// Times in ns. A step takes as long as the longer part, and what the host does.
typedef struct truth {
    double begin[2];       // time of a device, however little it does
    double each[2][MODES]; // time of all objects, whatever the share
    double own[2];         // time of an object that it does
    double power[2];       // own grows with n to this power
    double host_begin;     // added where both work
    double host_each;
    bool equal; // so that the default plan shares
    double noise;
} truth;

static truth invent(rng *r, double noise)
{
    truth t = {.equal = rng_below(r, 3) == 0, .noise = noise};
    double ratio = t.equal ? 1 : exp(rng_between(r, 0, log(64)));
    double speed[2] = {10 * (t.equal || rng_below(r, 4) ? ratio : 1), 10};
    double power = rng_between(r, -0.15, 0.05);
    for (int d = 0; d < 2; ++d) {
        t.own[d] = speed[d];
        t.begin[d] = t.equal && d == 1 ? t.begin[0] : exp(rng_between(r, log(5e3), log(5e5)));
        t.each[d][OWN] = speed[d] * rng_between(r, 0.05, 0.5);
        t.each[d][SLAB] = speed[d] * rng_between(r, 0, 0.2);
        t.power[d] = t.equal ? power : rng_between(r, -0.15, 0.05);
    }
    t.host_begin = exp(rng_between(r, log(1e3), log(1e5)));
    t.host_each = rng_between(r, 0, 1);
    return t;
}

static double part_time(const truth *t, int device, int mode, double n, double part)
{
    double shared = part < 1 ? t->each[device][mode] * n : 0;
    return t->begin[device] + shared + t->own[device] * part * n * pow(n / 1e5, t->power[device]);
}

static double step_time(const truth *t, const profile_plan *plan, double n)
{
    int mode = strcmp(plan->mode, "slab") == 0 ? SLAB : OWN;
    double share = plan->share / (double)PROFILE_SHARE_ONE;
    if (plan->share == 0 || plan->share == PROFILE_SHARE_ONE)
        return part_time(t, plan->share == 0, mode, n, 1);
    return t->host_begin + t->host_each * n +
           fmax(part_time(t, 0, mode, n, share), part_time(t, 1, mode, n, 1 - share));
}

static profile_plan plan_of(int mode, double share)
{
    profile_plan plan = test_plan(share);
    strcpy(plan.mode, mode_names[mode]);
    return plan;
}

static profile_plan default_plan(const truth *t)
{
    return plan_of(SLAB, t->equal ? 0.5 : 0);
}

// The best plan that shares.
static profile_plan best_shared(const truth *t, double n)
{
    profile_plan best = plan_of(SLAB, 1 / 256.0);
    for (int mode = 0; mode < MODES; ++mode)
        for (int i = 1; i < 256; ++i) {
            profile_plan plan = plan_of(mode, i / 256.0);
            if (step_time(t, &plan, n) < step_time(t, &best, n))
                best = plan;
        }
    return best;
}

static double noisy(const truth *t, rng *r, double ns)
{
    return ns * exp(t->noise * rng_normal(r));
}

// ---------------------------------------------------------------- tunings

static profile_workload workload_of(const char *family, double n)
{
    profile_workload w = test_workload((uint64_t)n);
    w.effects = family;
    return w;
}

static void add_trial(store *s, const char *session, const truth *t, rng *r, double n,
                      profile_plan plan)
{
    int mode = strcmp(plan.mode, "slab") == 0 ? SLAB : OWN;
    double share = plan.share / (double)PROFILE_SHARE_ONE;
    profile_sample sample = {.total_ns = 1, .at_ns = 1};
    profile_trial trial = {.plan = plan, .outcome = "ok", .samples = &sample, .n_samples = 1};
    trial.scope = PROFILE_SHARE_ONE;
    trial.median_ns = trial.low_ns = trial.high_ns = noisy(t, r, step_time(t, &plan, n));
    trial.a_ns = share > 0 ? noisy(t, r, part_time(t, 0, mode, n, share)) : 0;
    trial.b_ns = share < 1 ? noisy(t, r, part_time(t, 1, mode, n, 1 - share)) : 0;
    trial.terms = "{}";
    int64_t number;
    must(sql_find(s, "SELECT count(*) FROM trial WHERE session_id = ?", session, &number, ERR));
    must(profile_trial_add(s, session, number, &trial, ERR));
}

// Stores what a tuning leaves: the race's medians, its interval, and the best plan of those that
// raced.
static void tune(look_fixture *f, const char *family, const truth *t, rng *r, double n)
{
    char id[PROFILE_ID];
    profile_row row = {.kernels = TEST_KERNELS,
                       .objective = "time",
                       .origin = "measured",
                       .session = id,
                       .trial_number = 0};
    profile_workload workload = workload_of(family, n);
    must(profile_pair_put(f->s, &f->pair, &row.pair_id, ERR));
    must(profile_workload_put(f->s, &workload, &row.workload_id, ERR));
    profile_session session = test_session(row.pair_id, row.workload_id);
    must(profile_session_begin(f->s, &session, id, ERR));
    profile_plan best = best_shared(t, n), single[2] = {plan_of(SLAB, 1), plan_of(SLAB, 0)};
    for (int i = 0; i < 2; ++i)
        add_trial(f->s, id, t, r, n, single[i]);
    for (int i = 0; i < 8; ++i) {
        double share = best.share / (double)PROFILE_SHARE_ONE;
        share += (share < 0.5 ? share : 1 - share) * rng_between(r, -0.5, 0.5);
        add_trial(f->s, id, t, r, n, plan_of(i % 2, share));
    }
    int one = step_time(t, &single[1], n) < step_time(t, &single[0], n);
    double both_ns = noisy(t, r, step_time(t, &best, n));
    row.single_ns = noisy(t, r, step_time(t, &single[one], n));
    row.gain = row.single_ns / both_ns - 1;
    row.gain_low = row.gain - 3 * t->noise;
    row.gain_high = row.gain + 3 * t->noise;
    row.verdict = row.gain_low > 0 ? "faster" : row.gain_high < 0 ? "slower" : "same";
    row.best_share = best.share;
    row.best_mode = best.mode;
    row.plan = row.gain_low > 0 ? best : single[one];
    row.median_ns = row.low_ns = row.high_ns = row.gain_low > 0 ? both_ns : row.single_ns;
    must(profile_put(f->s, &row, NULL, "replaced", NULL, ERR));
    must(profile_session_end(f->s, id, "complete", ERR));
}

// ---------------------------------------------------------------- the property

static double draw_n(rng *r)
{
    return floor(exp(rng_between(r, log(LEAST_N), log(MOST_N))));
}

typedef struct losses {
    uint32_t n[PROFILE_DEFAULT + 1];
    double worst; // beside the default, as a part of it
} losses;

// Looks up a plan for n objects, beside the default plan.
static void ask(look_fixture *f, const char *family, const truth *t, double n, losses *l)
{
    profile_workload workload = workload_of(family, n);
    profile_request request = test_request(&f->pair, &workload);
    profile_found found = look_up(f->s, &request);
    profile_plan fallback = default_plan(t);
    const profile_plan *plan = found.grade < PROFILE_STALE ? &found.plan : &fallback;
    double loss = step_time(t, plan, n) / step_time(t, &fallback, n) - 1;
    ++l->n[found.grade];
    l->worst = fmax(l->worst, loss);
    if (loss > MOST_LOSS)
        print_message("%s, n %.0f: %s, share %.4f, mode %s, %.1f %% behind the default\n", family,
                      n, profile_grade_name(found.grade), plan->share / (double)PROFILE_SHARE_ONE,
                      plan->mode, 100 * loss);
}

TEST(no_plan_that_is_looked_up_loses_to_the_default)
{
    enum { ROUNDS = 80, QUESTIONS = 25 };
    uint64_t seed = test_seed();
    rng r = rng_seed(seed);
    look_fixture f = look_open();
    losses l = {0};
    must(store_begin(f.s, ERR));
    for (int round = 0; round < ROUNDS; ++round) {
        char family[32];
        snprintf(family, sizeof family, "round%d", round);
        truth t = invent(&r, 0.002);
        for (uint32_t i = 0, n = 1 + rng_below(&r, 4); i < n; ++i)
            tune(&f, family, &t, &r, draw_n(&r));
        for (int i = 0; i < QUESTIONS; ++i)
            ask(&f, family, &t, draw_n(&r), &l);
    }
    must(store_end(f.s, true, ERR));
    for (int g = 0; g <= PROFILE_DEFAULT; ++g)
        print_message("%s: %u\n", profile_grade_name((profile_grade)g), l.n[g]);
    print_message("at worst %.2f %% behind the default\n", 100 * l.worst);
    assert_true(l.worst <= MOST_LOSS);
    assert_true(l.n[PROFILE_INTERPOLATED] > 0 && l.n[PROFILE_TRANSFERRED] > 0);
}
