// SPDX-License-Identifier: MIT
#include "tuner/plan_times.h"

#include "tuner/stats.h"

#include <math.h>
#include <string.h>

enum { FIRST_SHARE = SEARCH_ONE / 16, FRAMES = 3 };

static const double WORTH_ALONE = 1.3; // A alone is learned if it may take so much of B alone

bool plan_is_shared(const listed_plan *plan)
{
    return search_is_shared(plan->share);
}

bool plan_is_same(const listed_plan *a, const listed_plan *b)
{
    if (!plan_is_shared(a) || !plan_is_shared(b))
        return a->share == b->share && a->variant[a->share == 0] == b->variant[a->share == 0];
    uint32_t apart = a->share > b->share ? a->share - b->share : b->share - a->share;
    return apart < PLAN_LEAST_SHARE && a->mode == b->mode &&
           memcmp(a->variant, b->variant, sizeof a->variant) == 0;
}

static double part_of(const listed_plan *plan, int device)
{
    uint32_t part = device == 0 ? plan->share : SEARCH_ONE - plan->share;
    return part / (double)SEARCH_ONE;
}

static part_line *line_of(plan_times *t, const listed_plan *plan, int device)
{
    uint32_t way = plan_is_shared(plan) ? plan->mode : PLAN_ALONE;
    return &t->lines[way][device][plan->variant[device]];
}

double plan_times_expect_part(const plan_times *t, const listed_plan *plan, int device)
{
    const part_line *line = line_of((plan_times *)t, plan, device);
    double part = part_of(plan, device), ns = line->base_ns + line->each_ns * part;
    return part > 0 && ns <= 0 ? INFINITY : part > 0 ? ns : 0;
}

double plan_times_expect(const plan_times *t, const listed_plan *plan)
{
    bool unfit = plan_is_shared(plan) && plan->mode == DUET_MODE_SHARED &&
                 plan->variant[0] != plan->variant[1];
    return unfit ? INFINITY
                 : fmax(plan_times_expect_part(t, plan, 0), plan_times_expect_part(t, plan, 1));
}

double plan_times_switch(const plan_times *t, const listed_plan *from, const listed_plan *to)
{
    bool same =
        from->mode == to->mode && memcmp(from->variant, to->variant, sizeof to->variant) == 0;
    return same ? 0 : t->switch_ns;
}

static uint32_t share_of(double part)
{
    double share = part * SEARCH_ONE;
    return (uint32_t)fmin(fmax(share, PLAN_LEAST_SHARE), SEARCH_ONE - PLAN_LEAST_SHARE);
}

// The share at which both devices are expected to end together, between 1/64 and 63/64.
static uint32_t best_share(const plan_times *t, const listed_plan *plan)
{
    const part_line *a = &t->lines[plan->mode][0][plan->variant[0]];
    const part_line *b = &t->lines[plan->mode][1][plan->variant[1]];
    double each = a->each_ns + b->each_ns;
    return share_of(each > 0 ? (b->base_ns + b->each_ns - a->base_ns) / each : 0);
}

uint32_t plan_times_largest_part(const plan_times *t, const listed_plan *plan, int device,
                                 double most_ns)
{
    const part_line *line = &t->lines[plan->mode][device][plan->variant[device]];
    return share_of(line->each_ns > 0 ? (most_ns - line->base_ns) / line->each_ns : 1);
}

static void scale(part_line *line, double by)
{
    line->base_ns *= by;
    line->each_ns *= by;
}

static void scale_device(plan_times *t, int device, double by)
{
    t->load[device] *= by;
    for (int way = 0; way < PLAN_WAYS; ++way)
        for (uint32_t v = 0; v < t->n_variants; ++v)
            scale(&t->lines[way][device][v], by);
}

static const double RECOVERY = 0.8;

void plan_times_recover(plan_times *t, int device)
{
    if (t->load[device] > 1)
        scale_device(t, device, fmax(RECOVERY, 1 / t->load[device]));
}

void plan_times_follow(plan_times *t, const search_sample *frame, const listed_plan *plan,
                       const bool all[2])
{
    const uint64_t ns[2] = {frame->a_ns, frame->b_ns};
    for (int device = 0; device < 2; ++device) {
        double expected = plan_times_expect_part(t, plan, device);
        if (!(expected > 0 && isfinite(expected)) || ns[device] == 0)
            continue;
        double ratio = (double)ns[device] / expected;
        if (all[device])
            scale_device(t, device, ratio);
        else
            scale(line_of(t, plan, device), ratio);
    }
}

void plan_times_forget(plan_times *t, const listed_plan *plan)
{
    for (int device = 0; device < 2; ++device)
        if (part_of(plan, device) > 0)
            *line_of(t, plan, device) = (part_line){0};
}

bool plan_times_rival(const plan_times *t, uint32_t i, listed_plan *rival)
{
    uint32_t v = t->n_variants, n_shared = PLAN_MODES * v * v;
    if (i >= n_shared + 2 * v)
        return false;
    *rival = (listed_plan){.mode = DUET_MODE_OWN, .variant = {i / v % v, i % v}};
    if (i < n_shared) {
        rival->mode = i / (v * v);
        rival->share = best_share(t, rival);
        return true;
    }
    rival->variant[0] = rival->variant[1] = i % v;
    rival->share = i < n_shared + v ? 0 : SEARCH_ONE;
    return true;
}

// ---------------------------------------------------------------- learning

// The median frame after one that warms up.
static bool run(const plan_runner *runner, const listed_plan *plan, search_sample *frame)
{
    search_sample frames[FRAMES];
    bool ok = runner->run(runner->context, plan, frame);
    for (int i = 0; ok && i < FRAMES; ++i)
        ok = runner->run(runner->context, plan, &frames[i]);
    if (ok)
        *frame = search_samples_median(frames, FRAMES);
    return ok;
}

static part_line line_through(double part, double ns, double other_part, double other_ns)
{
    double each = fmax((other_ns - ns) / (other_part - part), 0);
    double base = ns - each * part;
    return base >= 0 ? (part_line){base, each} : (part_line){0, other_ns / other_part};
}

// Returns the share at which both devices end together, or half the work: lines through points that
// are far apart are known best. A slow device is not to take long.
static uint32_t far_share(const plan_times *t, uint32_t v, double a_ns, double b_ns)
{
    enum { LONGEST = 4 }; // times B alone
    double fair = b_ns / (a_ns + b_ns);
    double most = LONGEST * t->lines[PLAN_ALONE][1][v].each_ns / a_ns;
    uint32_t share = share_of(fmax(fair, fmin(0.5, most)));
    return share < 2 * FIRST_SHARE ? PLAN_LEAST_SHARE : share;
}

static void learn_mode(plan_times *t, uint32_t mode, uint32_t v, const plan_runner *runner)
{
    listed_plan near = {FIRST_SHARE, mode, {v, v}}, far = near;
    search_sample first, other;
    if (!run(runner, &near, &first))
        return;
    far.share = far_share(t, v, (double)first.a_ns / part_of(&near, 0),
                          (double)first.b_ns / part_of(&near, 1));
    if (!run(runner, &far, &other))
        return;
    t->lines[mode][0][v] =
        line_through(part_of(&near, 0), (double)first.a_ns, part_of(&far, 0), (double)other.a_ns);
    t->lines[mode][1][v] =
        line_through(part_of(&near, 1), (double)first.b_ns, part_of(&far, 1), (double)other.b_ns);
}

static void learn_alone(plan_times *t, uint32_t share, uint32_t v, const plan_runner *runner)
{
    listed_plan plan = {share, DUET_MODE_OWN, {v, v}};
    search_sample frame;
    if (run(runner, &plan, &frame))
        *line_of(t, &plan, share == 0) = (part_line){.each_ns = (double)frame.total_ns};
}

// A may be so slow that it is not to do all of it even once.
static bool is_worth_alone(const plan_times *t, uint32_t v)
{
    double least = INFINITY;
    for (int mode = 0; mode < PLAN_MODES; ++mode) {
        const part_line *line = &t->lines[mode][0][v];
        if (line->base_ns + line->each_ns > 0)
            least = fmin(least, line->base_ns + line->each_ns);
    }
    return least < WORTH_ALONE * t->lines[PLAN_ALONE][1][v].each_ns;
}

// Each plan follows one with other kernels, and then itself.
static void learn_switch(plan_times *t, uint32_t modes, const plan_runner *runner)
{
    double extra[PLAN_MODES * PLAN_VARIANTS];
    uint32_t n = 0;
    for (uint32_t i = 0; i < PLAN_MODES * t->n_variants; ++i) {
        listed_plan plan = {0, i / t->n_variants, {i % t->n_variants, i % t->n_variants}};
        search_sample first, second;
        if (modes)
            plan.share = best_share(t, &plan);
        if (isfinite(plan_times_expect(t, &plan)) && runner->run(runner->context, &plan, &first) &&
            runner->run(runner->context, &plan, &second))
            extra[n++] = (double)first.total_ns - (double)second.total_ns;
    }
    t->switch_ns = n > 1 ? fmax(stats_median(extra, n), 0) : 0;
}

void plan_times_learn(plan_times *t, uint32_t n_variants, uint32_t modes, const plan_runner *runner)
{
    *t = (plan_times){.n_variants = n_variants, .load = {1, 1}};
    for (uint32_t v = 0; v < n_variants; ++v) {
        learn_alone(t, 0, v, runner);
        for (uint32_t mode = 0; mode < PLAN_MODES; ++mode)
            if (modes & 1u << mode)
                learn_mode(t, mode, v, runner);
        if (is_worth_alone(t, v))
            learn_alone(t, SEARCH_ONE, v, runner);
    }
    learn_switch(t, modes, runner);
}
