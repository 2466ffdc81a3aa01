// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "tuner/field.h"
#include "tuner/kernel_search.h"
#include "tuner/stages.h"
#include "tuner/stats.h"
#include "tuner/trial_budget.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FEW = 16 }; // configs of a kernel

static const double BEHIND = 1.07;          // in times of the fastest
static const double TRIALS_A_VALUE = 2.6;   // trials per value of a parameter, on invented kernels
static const double MAD_DEVIATION = 1.4826; // of normal noise
static const double WORTH_SEARCH = 0.03;    // a kernel that takes so much of its device's time
static const double WORTH_ALL = 0.5;        // and one whose few configs are all tried

// No race of so few rounds is 99 % sure of a gain of a tenth if times scatter by as much. A wrong
// choice costs no more than a right one gains, and both single devices are measured with it.
static const race_options confirmation = {
    .least_rounds = 8, .most_rounds = 16, .confidence = 0.8, .dropped = 1.02, .margin = 0.02};

// The configs as plans; one whose text would be too long is left out.
static uint32_t enter_configs(const duet_plan *plan, int device, const kernel_space *space,
                              uint32_t *configs, uint32_t n, field *f)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; ++i) {
        duet_plan with = *plan;
        if (!kernel_space_write(space, configs[i], plan_variant_of(&with, device)))
            continue;
        field_enter(f, with);
        configs[kept++] = configs[i];
    }
    return kept;
}

// Who takes so much longer than the fastest is out; returns how many are left.
static uint32_t drop_slower(const double *times, bool *out, uint32_t n)
{
    double least = INFINITY;
    uint32_t left = 0;
    for (uint32_t i = 0; i < n; ++i)
        least = fmin(least, times[i]);
    for (uint32_t i = 0; i < n; ++i) {
        out[i] = !(times[i] <= BEHIND * least);
        left += !out[i];
    }
    return left;
}

// One launch of each config that is still in. A config's time is the least that its kernel
// took, by the device's own clock: what disturbs a launch only adds to it. It stays INFINITY
// for one that does not run.
static void launch_configs(tuning *t, const field *f, const bool *out, double *times)
{
    for (uint32_t i = 0; i < f->n; ++i) {
        if (out[i] || !tuning_goes_on(t))
            continue;
        trial got = tuning_run_trial(t, &f->plans[i]);
        if (got.usable)
            times[i] = fmin(times[i], (double)got.focus_ns);
    }
}

// Races the best config so far, which is the first, with others. At first the others run alone: one
// that is clearly behind what the best took in the race before is out. Only if some are left the
// best runs too, in turn with them, since the machine may have become slower or faster.
static void screen_configs(tuning *t, const field *f, double best_ns,
                           double times[KERNEL_SPACE_VALUES])
{
    bool out[KERNEL_SPACE_VALUES] = {true};
    for (uint32_t i = 0; i < f->n; ++i)
        times[i] = INFINITY;
    launch_configs(t, f, out, times);
    times[0] = best_ns;
    uint32_t left = drop_slower(times, out, f->n);
    if (left == 1 && !out[0])
        return;
    out[0] = false;
    times[0] = INFINITY;
    launch_configs(t, f, out, times);
}

// Whether the kernel takes enough of its device's time for a search to pay; of one that takes most
// of it, all of few configs are tried.
static bool is_worth_search(tuning *t, const duet_plan *plan, int device, kernel_search *s)
{
    trial got = tuning_run_trial(t, plan);
    // B does more of a motion than the search that it shares.
    double whole = (double)(device == 0              ? got.sample.a_ns
                            : t->problem->def->steps ? got.sample.total_ns
                                                     : got.sample.b_ns);
    s->best_ns = (double)got.focus_ns;
    s->few = s->best_ns > WORTH_ALL * whole ? FEW : 0;
    return got.usable && s->best_ns > WORTH_SEARCH * whole;
}

// Varies the plan's kernel for a device, and keeps in the plan what was fastest.
static void search_kernel(tuning *t, int device, const kernel_space *space, duet_plan *plan)
{
    uint32_t configs[KERNEL_SPACE_VALUES], n;
    double times[KERNEL_SPACE_VALUES];
    kernel_search s = kernel_search_begin(space);
    t->focus = (focus){device, space->stages, KERNEL_SPACE_STAGES};
    if (!is_worth_search(t, plan, device, &s))
        return;
    while (tuning_goes_on(t) && (n = kernel_search_next(&s, configs)) > 0) {
        field f = {0};
        n = enter_configs(plan, device, space, configs, n, &f);
        screen_configs(t, &f, s.best_ns, times);
        kernel_search_tell(&s, configs, times, n);
    }
    t->outcome->kernels[device].configs += space->n_configs;
    t->outcome->kernels[device].tried += s.tried;
    kernel_space_write(space, s.best, plan_variant_of(plan, device));
}

// The stages of all the device's kernels.
static focus focus_on(const tuning *t, int device)
{
    static const char *const stages[] = {
        "search", "candidates", "narrow",     "reorder", "bounds",
        "hash",   "sort",       "cell start", "clear",   "kernel",
    };
    // Stages of a motion, in which the search is one of B's stages.
    static const char *const of_motion[] = {
        "pairs",         "integrate",      "manifolds", "sleep", "solve_contacts", "graph_colour",
        "contact_graph", "match_contacts", "fat_aabbs", "grid",  "events"};
    bool moves = device == 1 && t->problem->def->steps;
    return moves ? (focus){device, of_motion, sizeof of_motion / sizeof *of_motion}
                 : (focus){device, stages, sizeof stages / sizeof *stages};
}

// A device's first launch, and if it is short how far single ones scatter, which only the first
// trial warms up. Waiting for a core is no scatter of theirs: more launches would wait as well.
// Returns false if the plan does not run.
static bool launch_first(tuning *t, int device, const duet_plan *plan)
{
    enum { LAUNCHES = 5, ENOUGH = 4 };
    double ns[LAUNCHES];
    uint32_t n = 0, trials = 0;
    t->focus = focus_on(t, device);
    t->repeats = 1;
    t->scatter = INFINITY;
    do {
        trial got = tuning_run_trial(t, plan);
        if (!got.usable)
            return false;
        if (got.disturbed == 0)
            ns[n++] = (double)got.focus_ns;
    } while (++trials < LAUNCHES && tuning_count_launches(t, 1) > 1);
    if (n >= ENOUGH)
        t->scatter = MAD_DEVIATION * stats_mad(ns, n) / fmax(stats_median(ns, n), 1);
    else if (trials == LAUNCHES)
        t->scatter = 0;
    return true;
}

// Races what was found against what was there, by all kernels of the device. Only what is mostly
// faster is used.
static void confirm_kernels(tuning *t, int device, const duet_plan *before, const duet_plan *after)
{
    t->focus = focus_on(t, device);
    race_gain gain = trial_log_same_plan(before, after)
                         ? race_no_gain(RACE_SAME)
                         : field_duel(t, before, after, &confirmation);
    if (gain.verdict == RACE_FASTER)
        plan_set_variant(&t->plan, device, plan_variant(after, device));
    duet_kernel_search *told = &t->outcome->kernels[device];
    told->gain = gain.ratio - 1;
    told->gain_low = gain.interval.low - 1;
    told->gain_high = gain.interval.high - 1;
    snprintf(told->verdict, sizeof told->verdict, "%s", race_verdict_name(gain.verdict));
}

bool kernel_tuning_is_meant(const char *what, const kernel_space *space)
{
    return strcmp(what, "kernels") == 0 || strcmp(what, space->kernel) == 0;
}

// Whether A needs no search: it is B's device, or one of its kind with the same variant.
static bool is_like_b(const tuning *t)
{
    return t->problem->one_device ||
           (t->problem->fair > 0 && strcmp(t->plan.variant_a, t->plan.variant_b) == 0);
}

// Estimates the trials still to come: to search and confirm this device's kernels, and as many for
// the next device as for this one.
static void expect_trials(tuning *t, int device, const kernel_space *spaces, uint32_t n,
                          uint32_t so_far)
{
    uint32_t left = 2 * confirmation.most_rounds;
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t p = 0;
             kernel_tuning_is_meant(t->problem->def->search, &spaces[i]) && p < spaces[i].n_params;
             ++p)
            left += (uint32_t)(TRIALS_A_VALUE * (spaces[i].params[p].n_values - 1));
    uint32_t next = device == 1 && !is_like_b(t) ? so_far + left : 0;
    t->search_trials = t->state->played - t->search_begun + left + next;
}

static void search_device(tuning *t, int device, uint32_t share)
{
    const measure_machine *machine = &t->problem->machine;
    kernel_spaces spaces = {0};
    uint32_t launches = t->launches, begun = t->state->played;
    duet_plan before = tuning_plan(t, share, DUET_MODE_OWN), after = before;
    bool usable = launch_first(t, device, &before);
    t->found |= !usable; // the verdict tells why
    t->repeats = tuning_count_launches(t, 1);
    if (usable)
        machine->read_kernels(machine->context, &before, device, &spaces, &t->why);
    for (uint32_t i = 0; i < spaces.n && tuning_goes_on(t); ++i) {
        if (!kernel_tuning_is_meant(t->problem->def->search, &spaces.of[i]))
            continue;
        t->found = true;
        expect_trials(t, device, &spaces.of[i], spaces.n - i, t->state->played - begun);
        search_kernel(t, device, &spaces.of[i], &after);
    }
    kernel_spaces_free(&spaces);
    t->outcome->kernels[device].launches = t->launches - launches;
    confirm_kernels(t, device, &before, &after);
    t->focus.stages = NULL;
}

// Takes what a search led to on this device beside another device, if it is a variant that may be
// chosen.
static bool take_searched(tuning *t, int device)
{
    const char *searched = t->problem->searched[device], *base;
    bool taken = false;
    for (uint32_t i = 0; *searched && !taken && (base = tune_variant(t->problem->def, i)); ++i) {
        size_t length = strlen(base);
        taken = strncmp(searched, base, length) == 0 &&
                (searched[length] == '\0' || searched[length] == ' ');
    }
    if (taken)
        plan_set_variant(&t->plan, device, searched);
    t->found |= taken;
    return taken;
}

void kernel_tuning_run(tuning *t)
{
    uint32_t repeats = t->repeats;
    if (!t->problem->def->search)
        return;
    bool alike = is_like_b(t);
    t->search_begun = t->state->played;
    t->stage = "kernels of B";
    t->stage_end = (VARIANTS_END + KERNELS_END) / 2;
    if (!take_searched(t, 1) && tuning_goes_on(t))
        search_device(t, 1, alike ? t->problem->fair : 0);
    t->stage = "kernels of A";
    t->stage_end = KERNELS_END;
    if (alike)
        plan_set_variant(&t->plan, 0, t->plan.variant_b);
    else if (!take_searched(t, 0) && tuning_goes_on(t))
        search_device(t, 0, variants_share_of_a(t));
    t->repeats = repeats;
    t->search_trials = t->state->played - t->search_begun;
    if (!t->found && tuning_goes_on(t))
        error_set(&t->why, DUET_STATUS_NOT_FOUND,
                  "search '%s': neither device runs it with several configs by '%s' and '%s'",
                  t->problem->def->search, t->plan.variant_a, t->plan.variant_b);
}
