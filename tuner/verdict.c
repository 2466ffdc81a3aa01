// SPDX-License-Identifier: MIT
#include "base/budget.h"
#include "base/error.h"
#include "tuner/field.h"
#include "tuner/stages.h"
#include "tuner/strategy.h"
#include "tuner/trial_budget.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

enum { LEAST_TRIALS = 8 }; // from which a device's undisturbed time is taken

static const double WORTH_ALONE = 1.3;  // A alone is raced if it may take so much of B alone
static const double MOST_OF_SAME = 1.1; // a gain or a loss beyond this is not `same`
static const double UNEVEN = 1.03;      // a step that could be so much shorter is evened out
static const double SAME_SHARE = 0.06;  // between equal shares, as part of one

// All that the first race of a single shared plan chooses is the device alone.
static race_options first_race(uint32_t shared)
{
    race_options o = race_default_options();
    o.most_rounds = shared > 1 ? o.most_rounds : o.least_rounds;
    return o;
}

// Whether A alone may be the better single device. A search seldom runs it, and while B works as
// well A may take much longer for each item than alone: then a trial tells, unless even that may
// cost too much.
static bool may_be_better(tuning *t, const duet_plan *a_alone)
{
    double a_ns = INFINITY, b_ns = INFINITY;
    for (uint32_t i = 0; i < t->n_founds; ++i) {
        a_ns = fmin(a_ns, t->founds[i].a_alone_ns);
        b_ns = fmin(b_ns, t->founds[i].b_alone_ns);
    }
    if (a_ns < WORTH_ALONE * b_ns)
        return true;
    if (a_ns > search_default_options().probe_cost * b_ns || t->n_founds == 0 ||
        trial_log_of(t->state, a_alone, (int32_t)t->part, NULL) || !tuning_goes_on(t))
        return false;
    trial got = tuning_run_trial(t, a_alone);
    return got.usable && (double)got.sample.total_ns < WORTH_ALONE * b_ns;
}

// The devices alone come first, then the best share of each mode.
static uint32_t enter_rivals(tuning *t, field *f)
{
    const mode_found *founds = t->founds;
    const duet_plan a_alone = tuning_plan(t, DUET_SHARE_ONE, DUET_MODE_OWN);
    field_enter(f, tuning_plan(t, 0, DUET_MODE_OWN));
    if (may_be_better(t, &a_alone))
        field_enter(f, a_alone);
    uint32_t n_alone = f->n;
    for (uint32_t i = 0; i < t->n_founds; ++i) {
        if (founds[i].usable && search_is_shared(founds[i].share))
            field_enter(f, tuning_plan(t, founds[i].share, founds[i].mode));
    }
    return n_alone;
}

// Finds both devices' undisturbed times in all trials of a plan; false if there are too few.
static bool undisturbed(const tuning *t, const duet_plan *plan, double ns[2])
{
    double times[2][STATS_MOST];
    uint32_t n = 0;
    for (const trial *at = NULL; n < STATS_MOST && (at = trial_log_of(t->state, plan, t->part, at));
         ++n) {
        times[0][n] = (double)at->sample.a_ns;
        times[1][n] = (double)at->sample.b_ns;
    }
    for (int device = 0; device < 2 && n > 0; ++device)
        ns[device] = stats_quartile(times[device], n);
    return n >= LEAST_TRIALS;
}

// The share at which both devices would end together, by what each took for its
// part. A search has few launches, and while they lasted one device may have
// been slower than it mostly is.
static bool even_out(const tuning *t, const duet_plan *plan, duet_plan *even)
{
    double ns[2];
    if (!strategy_find(t->problem->def->strategy)->evened || !undisturbed(t, plan, ns))
        return false;
    double part = (double)plan->share / DUET_SHARE_ONE;
    double a = ns[0] / part, b = ns[1] / (1 - part); // each device's time for all the work
    double fair = b / (a + b);
    double quanta = floor(fair * DUET_SHARE_ONE / t->problem->least_share + 0.5);
    *even = *plan;
    even->share = (uint32_t)quanta * t->problem->least_share;
    return fmax(ns[0], ns[1]) > UNEVEN * fair * a && search_is_shared(even->share);
}

// Whether most trials of a plan had launches that waited for a core and count all the same: the
// system kept both parts on one, and the clock says nothing of sharing.
static bool is_mostly_disturbed(const tuning *t, const duet_plan *plan)
{
    uint32_t trials = 0, disturbed = 0;
    for (const trial *at = NULL; (at = trial_log_of(t->state, plan, t->part, at)); ++trials)
        disturbed += 2 * at->disturbed > at->launches;
    return t->problem->def->wait_seconds > 0 && 2 * disturbed > trials;
}

// Whether sharing may gain or lose much, though neither is proven, and there is a reason to expect
// that it gains: the devices are of one kind, or launches waited for a core.
static bool is_open(const tuning *t, const race_gain *gain)
{
    bool expected = t->problem->fair > 0 || t->disturbed > t->watched / 10;
    return t->problem->def->wait_seconds > 0 && gain->verdict == RACE_SAME &&
           fmax(gain->interval.high, 1 / gain->interval.low) > MOST_OF_SAME && expected;
}

// Says why a race that was run to its end proves nothing; false if it proves something.
static bool is_void(const tuning *t, const duet_plan *best, const race_gain *gain,
                    char because[128])
{
    if (gain->verdict != RACE_FASTER && is_mostly_disturbed(t, best)) {
        snprintf(because, 128, "both parts were on one core");
        return true;
    }
    if (!is_open(t, gain))
        return false;
    snprintf(because, 128,
             "times vary too much: %" PRIu32 " of %" PRIu32 " launches waited for a core",
             t->disturbed, t->watched);
    return true;
}

static void judge(tuning *t, const field *f, uint32_t alone, uint32_t best)
{
    duet_tune_outcome *outcome = t->outcome;
    race_gain gain = best == alone ? race_no_gain(t->cut ? RACE_AMBIGUOUS : RACE_SAME)
                                   : race_compare(&f->race, best, alone);
    if (best != alone && is_void(t, &f->plans[best], &gain, outcome->unused))
        gain.verdict = RACE_AMBIGUOUS;
    uint32_t use = gain.verdict == RACE_FASTER ? best : alone;
    outcome->best = f->plans[best];
    outcome->plan = f->plans[use];
    t->alone = f->plans[alone];
    outcome->terms = f->terms[best];
    outcome->gain = gain.ratio - 1;
    outcome->gain_low = gain.interval.low - 1;
    outcome->gain_high = gain.interval.high - 1;
    outcome->rounds = best == alone ? 0 : race_rounds(&f->race, best, alone);
    snprintf(outcome->verdict, sizeof outcome->verdict, "%s", race_verdict_name(gain.verdict));
    stats_interval in =
        stats_median_interval(f->race.rivals[use].ns, f->race.rivals[use].rounds, 0.95);
    outcome->step_ms = race_median(&f->race, use) * 1e-6;
    outcome->step_low_ms = in.low * 1e-6;
    outcome->step_high_ms = in.high * 1e-6;
    outcome->single_ms = race_median(&f->race, alone) * 1e-6;
}

static void fail_unmeasured(tuning *t)
{
    if (t->failure.status != DUET_STATUS_OK)
        error_copy(&t->why, &t->failure);
    bad_argument(&t->why,
                 "the budget ended before the devices were compared; expected more than %u trials "
                 "or %.3g seconds",
                 t->state->played, (double)t->spent_ns * 1e-9);
}

// The plans to expect of two devices of one kind: the share by their units in the mode of the
// default plan, or if that was not searched in the mode of the best shared plan; first with the
// kernels that were chosen, then with the default ones, if these are among those to choose from.
typedef struct expectation {
    duet_plan plans[2];
    uint32_t n;
} expectation;

static expectation expect_plans(const tuning *t, const duet_plan *shared)
{
    expectation e = {.plans[0] = *shared, .n = t->problem->fair > 0 ? 1 : 0};
    e.plans[0].share = t->problem->fair;
    for (uint32_t i = 0; i < t->n_founds; ++i)
        if (t->founds[i].usable && t->founds[i].mode == t->problem->fair_mode)
            e.plans[0].mode = t->founds[i].mode;
    e.plans[1] = e.plans[0];
    for (int device = 0; device < 2; ++device)
        plan_set_variant(&e.plans[1], device, plan_variant(&t->problem->plan, device));
    // A search of kernels' parameters has proven that they are faster.
    const duet_tune_def *def = t->problem->def;
    if (e.n > 0 && !def->search && tune_has_variant(def, t->problem->plan.variant_a) &&
        tune_has_variant(def, t->problem->plan.variant_b))
        e.n = 2;
    return e;
}

// Whether a plan is an expected one but for a share that noise may have led to.
static bool is_nearly(const duet_plan *plan, const duet_plan *expected)
{
    duet_plan same = *plan;
    same.share = expected->share;
    return trial_log_same_plan(&same, expected) &&
           fabs((double)plan->share - expected->share) < SAME_SHARE * expected->share;
}

// The single device and the shared plan once more, with its evened share, and the expected plans.
static void race_finalists(tuning *t, const duet_plan *alone, const duet_plan *shared,
                           const expectation *e, field *f)
{
    duet_plan even;
    *f = (field){0};
    field_enter(f, *alone);
    if (e->n == 0 || !is_nearly(shared, &e->plans[0]))
        field_enter(f, *shared);
    if (even_out(t, shared, &even))
        field_enter_new(f, &even);
    for (uint32_t i = 0; i < e->n; ++i)
        field_enter_new(f, &e->plans[i]);
    race_options last = trial_budget_last_race;
    last.usual = e->n > 0 ? field_find(f, &e->plans[e->n - 1]) : 0;
    field_race(t, f, &last);
}

// The best of the shared plans. An expected plan stays unless another is proven to be faster: in
// a few noisy launches the best of several plans is seldom the best one.
static uint32_t best_finalist(const field *f, const expectation *e)
{
    uint32_t best = race_best(&f->race, 1, f->n);
    for (uint32_t i = 0; i < e->n && best < f->n; ++i) {
        uint32_t expected = field_find(f, &e->plans[i]);
        if (expected < f->n && expected != best && f->race.rivals[expected].rounds > 0 &&
            race_compare(&f->race, best, expected).verdict != RACE_FASTER)
            best = expected;
    }
    return best;
}

// Without a rival: the time of a step, and its interval.
static void run_alone(tuning *t, field *f)
{
    f->race = race_begin(f->n, NULL);
    for (uint32_t i = 0; i < LEAST_RACED && tuning_goes_on(t); ++i) {
        trial got = tuning_run_trial(t, &f->plans[0]);
        if (got.usable)
            race_add(&f->race, 0, (double)got.sample.total_ns);
        f->terms[0] = got.terms;
    }
}

void verdict_reach(tuning *t)
{
    field all = {0}, finalists;
    t->stage = "verdict";
    t->stage_end = t->problem->whole.open ? VERDICT_END : ALL;
    t->repeats = t->repeats < VERDICT_REPEATS ? t->repeats : VERDICT_REPEATS;
    if (t->problem->def->search)
        t->repeats = tuning_count_launches(t, t->repeats);
    uint32_t n_alone = enter_rivals(t, &all);
    race_options first = first_race(all.n - n_alone);
    if (all.n > 1)
        field_race(t, &all, &first);
    else
        run_alone(t, &all);
    uint32_t alone = race_best(&all.race, 0, n_alone);
    uint32_t shared = race_best(&all.race, n_alone, all.n);
    if (alone == n_alone) {
        fail_unmeasured(t);
    } else if (shared == all.n) {
        judge(t, &all, alone, alone);
    } else {
        expectation e = expect_plans(t, &all.plans[shared]);
        race_finalists(t, &all.plans[alone], &all.plans[shared], &e, &finalists);
        uint32_t best = best_finalist(&finalists, &e);
        // The budget may have ended before or in this race: then the first one's samples must do.
        if (best < finalists.n && race_rounds(&finalists.race, best, 0) >= LEAST_RACED)
            judge(t, &finalists, 0, best);
        else
            judge(t, &all, alone, shared);
    }
}

void verdict_race_whole(tuning *t)
{
    const tune_whole *whole = &t->problem->whole;
    duet_tune_outcome *outcome = t->outcome;
    measure_machine machine;
    field f = {.plans = {outcome->plan}, .n = 2, .whole = &machine};
    if (!whole->open || t->why.status != DUET_STATUS_OK)
        return;
    if (!whole->open(whole->context, outcome->plan.variant_b, &machine, &f.plans[1])) {
        if (!budget_check_stop(NULL))
            tuning_stop(t);
        return;
    }
    t->stage = "undivided";
    t->stage_end = ALL;
    field_race(t, &f, NULL);
    if (race_rounds(&f.race, 0, 1) < LEAST_RACED)
        return;
    race_gain gain = race_compare(&f.race, 0, 1);
    outcome->whole_ms = race_median(&f.race, 1) * 1e-6;
    outcome->whole_gain = gain.ratio - 1;
    outcome->whole_gain_low = gain.interval.low - 1;
    outcome->whole_gain_high = gain.interval.high - 1;
}
