// SPDX-License-Identifier: MIT
#include "tuner/kernel_tuning.h"

#include "base/error.h"
#include "tuner/field.h"
#include "tuner/kernel_search.h"
#include "tuner/trial_budget.h"
#include "tuner/variants.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double BEHIND = 1.07;        // in times of the fastest
static const double TRIALS_A_VALUE = 2.6; // trials per value of a parameter, on invented kernels
static const double WORTH_SEARCH = 0.03;  // a kernel that takes so much of its device's time

static const race_options confirmation = {
    .least_rounds = 10, .most_rounds = 24, .confidence = 0.99, .dropped = 1.02, .margin = 0.02};

// The configs as plans; one whose text would be too long is left out.
static uint32_t enter_configs(const duet_plan *plan, int device, const kernel_space *space,
                              uint32_t *configs, uint32_t n, field *f)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; ++i) {
        duet_plan with = *plan;
        char *to = device == 0 ? with.variant_a : with.variant_b;
        if (!kernel_space_write(space, configs[i], plan_variant(plan, device), to, DUET_VARIANT))
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
static bool launch_configs(tuning *t, const field *f, const bool *out, double *times,
                           duet_error *err)
{
    for (uint32_t i = 0; i < f->n; ++i) {
        trial got;
        if (out[i] || !tuning_within_budget(t))
            continue;
        if (!tuning_run_trial(t, &f->plans[i], &got, err))
            return false;
        if (got.usable)
            times[i] = fmin(times[i], (double)got.focus_ns);
    }
    return true;
}

// Races the best config so far, which is the first, with others. At first the others run alone: one
// that is clearly behind what the best took in the race before is out. Only if some are left the
// best runs too, in turn with them, since the machine may have become slower or faster.
static bool screen_configs(tuning *t, const field *f, double best_ns,
                           double times[KERNEL_SPACE_VALUES], duet_error *err)
{
    bool out[KERNEL_SPACE_VALUES] = {true};
    for (uint32_t i = 0; i < f->n; ++i)
        times[i] = INFINITY;
    if (!launch_configs(t, f, out, times, err))
        return false;
    times[0] = best_ns;
    uint32_t left = drop_slower(times, out, f->n);
    if (left == 1 && !out[0])
        return true;
    out[0] = false;
    times[0] = INFINITY;
    return launch_configs(t, f, out, times, err);
}

// Whether the kernel takes enough of its device's time for a search to pay.
static bool is_worth_search(tuning *t, const duet_plan *plan, int device, bool *worth,
                            double *kernel_ns, duet_error *err)
{
    trial got;
    if (!tuning_run_trial(t, plan, &got, err))
        return false;
    // B does more of a motion than the search that it shares.
    double whole = (double)(device == 0              ? got.sample.a_ns
                            : t->problem->def->steps ? got.sample.total_ns
                                                     : got.sample.b_ns);
    *kernel_ns = (double)got.focus_ns;
    *worth = got.usable && (double)got.focus_ns > WORTH_SEARCH * whole;
    return true;
}

// Varies the plan's kernel for a device, and keeps in the plan what was fastest.
static bool search_kernel(tuning *t, int device, const kernel_space *space, duet_plan *plan,
                          duet_kernel_search *told, duet_error *err)
{
    uint32_t configs[KERNEL_SPACE_VALUES], n;
    double times[KERNEL_SPACE_VALUES];
    bool worth;
    kernel_search s = kernel_search_begin(space);
    t->focus = (focus){device, space->stages, KERNEL_SPACE_STAGES};
    if (!is_worth_search(t, plan, device, &worth, &s.best_ns, err))
        return false;
    while (worth && tuning_within_budget(t) && (n = kernel_search_next(&s, configs)) > 0) {
        field f = {0};
        n = enter_configs(plan, device, space, configs, n, &f);
        if (!screen_configs(t, &f, s.best_ns, times, err))
            return false;
        kernel_search_tell(&s, configs, times, n);
    }
    told->configs += worth ? space->n_configs : 0;
    told->tried += worth ? s.tried : 0;
    char variant[DUET_VARIANT];
    if (kernel_space_write(space, s.best, plan_variant(plan, device), variant, sizeof variant))
        plan_set_variant(plan, device, variant);
    return true;
}

// Races what was found against what was there, by all kernels of the device. Only what is faster
// for sure is used.
static bool confirm_kernels(tuning *t, int device, const duet_plan *before, const duet_plan *after,
                            duet_kernel_search *told, duet_error *err)
{
    static const char *const stages[] = {
        "search", "candidates", "narrow",     "reorder", "bounds",
        "hash",   "sort",       "cell start", "clear",   "kernel",
    };
    // Stages of a motion, in which the search is one of B's stages.
    static const char *const of_motion[] = {
        "pairs",         "integrate",      "manifolds", "sleep", "solve_contacts", "graph_colour",
        "contact_graph", "match_contacts", "fat_aabbs", "grid",  "events"};
    race_gain gain = {.verdict = RACE_SAME, .ratio = 1, .interval = {1, 1, 1}};
    bool moves = device == 1 && t->problem->def->steps;
    t->focus = moves ? (focus){device, of_motion, sizeof of_motion / sizeof *of_motion}
                     : (focus){device, stages, sizeof stages / sizeof *stages};
    if (!trial_log_same_plan(before, after)) {
        field f = {0};
        field_enter(&f, *before);
        field_enter(&f, *after);
        if (!field_race(t, &f, &confirmation, false, INFINITY, err))
            return false;
        gain.verdict = RACE_AMBIGUOUS;
        if (f.race.rivals[0].rounds > 0 && f.race.rivals[1].rounds > 0)
            gain = race_compare(&f.race, 1, 0);
    }
    if (gain.verdict == RACE_FASTER)
        plan_set_variant(&t->plan, device, plan_variant(after, device));
    told->gain = gain.ratio - 1;
    told->gain_low = gain.interval.low - 1;
    told->gain_high = gain.interval.high - 1;
    snprintf(told->verdict, sizeof told->verdict, "%s", race_verdict_name(gain.verdict));
    return true;
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
    t->search_known = true;
    t->search_trials = t->state->played - t->search_begun + left + next;
}

static bool search_device(tuning *t, int device, uint32_t share, duet_kernel_search *told,
                          duet_error *err)
{
    const tune_kernels *kernels = &t->problem->kernels;
    kernel_space *spaces = NULL;
    uint32_t n = 0, launches = t->launches, begun = t->state->played;
    trial got;
    duet_plan before = tuning_plan(t, share, DUET_MODE_OWN), after = before;
    if (!tuning_run_trial(t, &before, &got, err))
        return false;
    t->found |= !got.usable; // the verdict tells why
    bool ok = !got.usable || kernels->read(kernels->context, &before, device, &spaces, &n, err);
    for (uint32_t i = 0; ok && i < n && tuning_within_budget(t); ++i) {
        if (!kernel_tuning_is_meant(t->problem->def->search, &spaces[i]))
            continue;
        t->found = true;
        expect_trials(t, device, &spaces[i], n - i, t->state->played - begun);
        ok = search_kernel(t, device, &spaces[i], &after, told, err);
    }
    free(spaces);
    told->launches = t->launches - launches;
    ok = ok && confirm_kernels(t, device, &before, &after, told, err);
    t->focus.stages = NULL;
    return ok;
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

bool kernel_tuning_run(tuning *t, duet_kernel_search told[2], duet_error *err)
{
    uint32_t repeats = t->repeats, share;
    if (!t->problem->def->search)
        return true;
    bool alike = is_like_b(t);
    t->search_begun = t->state->played;
    t->stage = "kernels of B";
    t->stage_end = (VARIANTS_END + KERNELS_END) / 2;
    t->repeats = 1;
    bool ok =
        take_searched(t, 1) || !tuning_within_budget(t) || search_device(t, 1, 0, &told[1], err);
    t->stage = "kernels of A";
    t->stage_end = KERNELS_END;
    if (alike)
        plan_set_variant(&t->plan, 0, t->plan.variant_b);
    else
        ok = ok &&
             (take_searched(t, 0) || !tuning_within_budget(t) ||
              (variants_share_of_a(t, &share, err) && search_device(t, 0, share, &told[0], err)));
    t->repeats = repeats;
    t->search_known = true;
    t->search_trials = t->state->played - t->search_begun;
    if (ok && !t->found && tuning_within_budget(t))
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "search '%s': neither device runs it with several configs by '%s' and "
                         "'%s'",
                         t->problem->def->search, t->plan.variant_a, t->plan.variant_b);
    return ok;
}
