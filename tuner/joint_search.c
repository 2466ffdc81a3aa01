// SPDX-License-Identifier: MIT
#include "tuner/field.h"
#include "tuner/joint_space.h"
#include "tuner/stages.h"
#include "tuner/strategy.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdlib.h>

enum { POINTS = 16, FINALISTS = 6 };

static const race_options finals = {
    .least_rounds = 6, .most_rounds = 12, .confidence = 0.95, .dropped = 1.1, .margin = 0.02};

static const strategy *strategy_for(const tune_problem *problem)
{
    return strategy_of(problem->def->strategy, problem->script);
}

bool joint_search_is_asked(const tune_problem *problem)
{
    const strategy *s = strategy_for(problem);
    return s && s->choice != STRATEGY_SHARE;
}

// ---------------------------------------------------------------- space

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

// ---------------------------------------------------------------- search

static uint32_t count_samples(const strategy *of, const joint_space *space)
{
    enum { LEAST = 24, MOST = 400, ALL_PLANS = 100000 };
    uint64_t n = joint_space_count(space);
    if (of->choice == STRATEGY_JOINT_ALL)
        return (uint32_t)(n < ALL_PLANS ? n : ALL_PLANS);
    return n / 10 < LEAST ? LEAST : n / 10 > MOST ? MOST : (uint32_t)(n / 10);
}

// ---------------------------------------------------------------- choice

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
    field_race(t, &f, &finals, false, INFINITY);
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

static mode_found choose(tuning *t, search *h)
{
    mode_found found = {.mode = h->space->base.mode,
                        .a_alone_ns = expect_alone(h, 0),
                        .b_alone_ns = expect_alone(h, 1)};
    if (h->n > 0)
        qsort(h->samples, h->n, sizeof *h->samples, by_time);
    found.usable = h->n > 0 && !h->samples[0].failed;
    duet_plan best = race_best_few(t, h);
    found.share = best.share;
    plan_set_variant(&t->plan, 0, best.variant_a);
    plan_set_variant(&t->plan, 1, best.variant_b);
    return found;
}

void joint_search_run(tuning *t)
{
    joint_space s;
    t->stage = "kernels and share";
    t->stage_end = SEARCH_END;
    read_space(t, &s);
    search joint = {.strategy = strategy_for(t->problem),
                    .space = &s,
                    .script = t->problem->script,
                    .seed = t->problem->def->seed};
    joint.options.launches = count_samples(joint.strategy, &s);
    t->search_known = true;
    t->search_trials = joint.options.launches + FINALISTS * finals.most_rounds;
    mode_search_ask(t, &joint);
    uint64_t plans = joint_space_count(&s);
    t->outcome->plans = plans < UINT32_MAX ? (uint32_t)plans : UINT32_MAX;
    t->outcome->plans_tried = joint.n;
    t->founds[0] = choose(t, &joint);
    t->n_founds = 1;
    search_end(&joint);
    joint_space_free(&s);
}
