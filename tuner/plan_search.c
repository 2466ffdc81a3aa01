// SPDX-License-Identifier: MIT
// The search for the plan: the best share in each mode, or kernels and share together.
#include "tuner/field.h"
#include "tuner/joint_space.h"
#include "tuner/stages.h"
#include "tuner/strategy.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 16, FINALISTS = 6 };

static const race_options finals = {
    .least_rounds = 6, .most_rounds = 12, .confidence = 0.95, .dropped = 1.1, .margin = 0.02};

// Measures the plans that a strategy wants, until it or the budget ends. A strategy for the share
// ends at a plan that does not run, and false says so; others are told.
static bool ask_strategy(tuning *t, search *s)
{
    const bool joint = s->strategy->choice != STRATEGY_SHARE;
    bool usable = true;
    while (usable || joint) {
        search_next next;
        duet_plan plan;
        trial got = {0};
        if (!search_ask(s, &next, &t->why))
            break;
        t->cut |= !next.done && !tuning_goes_on(t);
        if (next.done || t->cut)
            break;
        if (joint_space_plan(s->space, &next.at, &plan))
            got = tuning_run_trial(t, &plan);
        usable = got.usable;
        next.at.total_ns = got.sample.total_ns;
        next.at.a_ns = got.sample.a_ns;
        next.at.b_ns = got.sample.b_ns;
        next.at.failed = !usable;
        if ((usable || joint) && !search_tell(s, &next.at, &t->why))
            break;
    }
    return usable;
}

// ---------------------------------------------------------------- share

// A's time for all the work, from the least and the largest part that it did.
static double expect_a_alone(const search *h)
{
    const search_sample *small = NULL, *large = NULL;
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        if (at->a_ns == 0)
            continue;
        if (!small || at->share < small->share)
            small = at;
        if (!large || at->share > large->share)
            large = at;
    }
    if (!large)
        return INFINITY;
    if (large->share == small->share)
        return (double)large->a_ns * DUET_SHARE_ONE / large->share;
    double slope = ((double)large->a_ns - (double)small->a_ns) / (large->share - small->share);
    return (double)large->a_ns + fmax(slope, 0) * (DUET_SHARE_ONE - large->share);
}

// near: a share to begin from; 0: none is known.
static mode_found search_mode(tuning *t, duet_mode mode, uint32_t near)
{
    search s;
    const joint_space share_alone = {.base = tuning_plan(t, 0, mode)};
    search_options options = search_default_options();
    options.quantum = t->problem->least_share;
    options.start = near;
    mode_found found = {.mode = mode, .a_alone_ns = INFINITY, .b_alone_ns = INFINITY};
    if (!search_begin(&s, t->problem->def->strategy, &options, &t->why))
        return found;
    s.script = t->problem->script;
    s.space = &share_alone;
    found.usable = ask_strategy(t, &s) && s.n > 0;
    found.share = search_pick(&s);
    // One device alone may only seem the best if the search was cut short.
    if (t->cut && (found.share == 0 || found.share == DUET_SHARE_ONE))
        found.share = search_first_share(&s);
    found.a_alone_ns = expect_a_alone(&s);
    const search_sample *b_alone = search_at(&s, 0);
    if (b_alone)
        found.b_alone_ns = (double)b_alone->total_ns;
    search_end(&s);
    return found;
}

// One device's grid is of no use to the other if they search differently.
static bool mode_fits(const duet_plan *plan, duet_mode mode)
{
    size_t a = strcspn(plan->variant_a, " "), b = strcspn(plan->variant_b, " ");
    return mode == DUET_MODE_OWN || mode == DUET_MODE_SLAB ||
           (mode == DUET_MODE_SHARED && a == b &&
            strncmp(plan->variant_a, plan->variant_b, a) == 0);
}

static uint32_t list_modes(const tuning *t, duet_mode modes[MOST_MODES])
{
    const duet_tune_def *def = t->problem->def;
    uint32_t n = 0;
    for (uint32_t i = 0; n < MOST_MODES && (i < def->n_modes || def->n_modes == 0); ++i) {
        duet_mode mode = def->n_modes ? def->modes[i] : (duet_mode)i;
        if (!duet_mode_name(mode))
            break;
        if (mode_fits(&t->plan, mode))
            modes[n++] = mode;
    }
    return n;
}

static void search_modes(tuning *t)
{
    duet_mode modes[MOST_MODES];
    uint32_t near = t->problem->start;
    const double from = t->problem->def->search ? KERNELS_END : VARIANTS_END;
    t->n_founds = t->problem->one_device ? 0 : list_modes(t, modes);
    t->stage = "share";
    for (uint32_t i = 0; i < t->n_founds; ++i) {
        t->stage_end = from + (SEARCH_END - from) * (i + 1) / t->n_founds;
        t->founds[i] = search_mode(t, modes[i], near);
        near = t->founds[i].usable ? t->founds[i].share : near;
    }
}

// ---------------------------------------------------------------- kernels and share

// Adds the kernels of a device that the search is meant for.
static void add_kernels(tuning *t, joint_space *s, int device)
{
    const measure_machine *machine = &t->problem->machine;
    kernel_spaces spaces = {0};
    bool ok = machine->read_kernels(machine->context, &s->base, device, &spaces, &t->why);
    for (uint32_t i = 0; ok && i < spaces.n; ++i)
        ok = !kernel_tuning_is_meant(t->problem->def->search, &spaces.of[i]) ||
             joint_space_add(s, device, &spaces.of[i], &t->why);
    kernel_spaces_free(&spaces);
}

static void read_space(tuning *t, joint_space *s)
{
    const tune_problem *problem = t->problem;
    uint32_t half = problem->one_device ? 0 : DUET_SHARE_ONE / 2;
    duet_mode mode = problem->def->n_modes ? problem->def->modes[0] : DUET_MODE_OWN;
    *s = (joint_space){.points = problem->one_device ? 0 : POINTS,
                       .base = tuning_plan(t, half, mode)};
    bool usable = tuning_run_trial(t, &s->base).usable;
    for (int device = problem->one_device ? 1 : 0; problem->def->search && usable && device < 2;
         ++device)
        add_kernels(t, s, device);
}

static uint32_t count_samples(const strategy *of, const joint_space *space)
{
    enum { LEAST = 24, MOST = 400, ALL_PLANS = 100000 };
    uint64_t n = joint_space_count(space);
    if (of->choice == STRATEGY_JOINT_ALL)
        return (uint32_t)(n < ALL_PLANS ? n : ALL_PLANS);
    return n / 10 < LEAST ? LEAST : n / 10 > MOST ? MOST : (uint32_t)(n / 10);
}

// Returns as many as leave enough of a budget in trials for the race of the best few; half of it at
// least.
static uint32_t count_affordable(const tuning *t, uint32_t n)
{
    double left = trial_budget_end(t->problem, SEARCH_END) - t->state->played;
    double most = fmax(left - FINALISTS * finals.least_rounds, left / 2);
    return t->problem->def->budget_trials == 0 || most > n ? n : (uint32_t)fmax(most, 1);
}

static int by_time(const void *a, const void *b)
{
    const search_sample *x = a, *y = b;
    if (x->failed != y->failed)
        return x->failed ? 1 : -1;
    return (x->total_ns > y->total_ns) - (x->total_ns < y->total_ns);
}

// The best of many short times is mostly one that was lucky, so the best few race.
static duet_plan race_best_few(tuning *t, const search *h)
{
    field f = {0};
    for (uint32_t i = 0; i < h->n && f.n < FINALISTS; ++i) {
        duet_plan plan;
        if (!h->samples[i].failed && joint_space_plan(h->space, &h->samples[i], &plan))
            field_enter_new(&f, &plan);
    }
    if (f.n == 0)
        return h->space->base;
    field_race(t, &f, &finals);
    uint32_t winner = race_best(&f.race, 0, f.n);
    return f.plans[winner < f.n ? winner : 0];
}

// The least that a device would take for all the work, by its part in any launch.
static double expect_alone(const search *h, int device)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        uint32_t part = device == 0 ? at->share : SEARCH_ONE - at->share;
        uint64_t ns = device == 0 ? at->a_ns : at->b_ns;
        if (!at->failed && part > 0 && ns > 0)
            least = fmin(least, (double)ns * SEARCH_ONE / part);
    }
    return least;
}

// If one device does it all, the share and the other device's kernels are those of the best plan
// that shares: the verdict tells what that gains or loses.
static void add_shared(const search *h, duet_plan *best)
{
    duet_plan shared;
    for (uint32_t i = 0; i < h->n && !search_is_shared(best->share); ++i) {
        const search_sample *at = &h->samples[i];
        if (at->failed || !search_is_shared(at->share) || !joint_space_plan(h->space, at, &shared))
            continue;
        int idle = best->share == 0 ? 0 : 1;
        plan_set_variant(best, idle, plan_variant(&shared, idle));
        best->share = shared.share;
    }
}

static mode_found choose(tuning *t, search *h)
{
    mode_found found = {.mode = h->space->base.mode,
                        .a_alone_ns = expect_alone(h, 0),
                        .b_alone_ns = expect_alone(h, 1)};
    if (h->n > 0)
        qsort(h->samples, h->n, sizeof *h->samples, by_time);
    found.usable = h->n > 0 && !h->samples[0].failed;
    duet_plan best = race_best_few(t, h);
    add_shared(h, &best);
    found.share = best.share;
    plan_set_variant(&t->plan, 0, best.variant_a);
    plan_set_variant(&t->plan, 1, best.variant_b);
    return found;
}

static void search_jointly(tuning *t, const strategy *by)
{
    joint_space s;
    t->stage = "kernels and share";
    t->stage_end = SEARCH_END;
    read_space(t, &s);
    search joint = {
        .strategy = by, .space = &s, .script = t->problem->script, .seed = t->problem->def->seed};
    joint.options.launches = count_affordable(t, count_samples(joint.strategy, &s));
    t->search_trials = joint.options.launches + FINALISTS * finals.most_rounds;
    ask_strategy(t, &joint);
    uint64_t plans = joint_space_count(&s);
    t->outcome->plans = plans < UINT32_MAX ? (uint32_t)plans : UINT32_MAX;
    t->outcome->plans_tried = joint.n;
    t->founds[0] = choose(t, &joint);
    t->n_founds = 1;
    search_end(&joint);
    joint_space_free(&s);
}

void plan_search_run(tuning *t)
{
    const strategy *by = strategy_of(t->problem->def->strategy, t->problem->script);
    if (by && by->choice != STRATEGY_SHARE) {
        search_jointly(t, by);
    } else {
        kernel_tuning_run(t);
        search_modes(t);
    }
    for (uint32_t i = 0; t->problem->meter && i < t->n_founds; ++i)
        t->founds[i].a_alone_ns = 0; // a slow device may be the more efficient one, and is raced
}
