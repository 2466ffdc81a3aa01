// SPDX-License-Identifier: MIT
#include "tuner/tune.h"

#include "base/budget.h"
#include "base/error.h"
#include "tuner/kernel_search.h"
#include "tuner/race.h"
#include "tuner/search.h"
#include "tuner/strategy.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_MODES = 8,
    VERDICT_REPEATS = 2, // at most, of which the quicker is typical
    LEAST_TRIALS = 8,    // from which a device's undisturbed time is taken
    LEAST_SEARCHED = 3,  // trials of a mode
    LEAST_RACED = 8,     // rounds from which a verdict has its confidence
};

// Parts of the budget. The search ends sooner where a verdict takes more trials.
static const double VARIANTS_END = 0.35, KERNELS_END = 0.55, SEARCH_END = 0.7, VERDICT_END = 0.9,
                    ALL = 1;

static const double WORTH_ALONE = 1.3;   // A alone is raced where it may take so much of B alone
static const double UNEVEN = 1.03;       // a step that could be so much shorter is evened out
static const double HOPELESS = 2.0;      // a plan this much slower is dropped from a quick race
static const double WORTH_SEARCH = 0.03; // a kernel that takes so much of its device's time

// The stages of a device whose kernel is varied.
typedef struct focus {
    int device;
    const char *const *stages; // NULL: none
    uint32_t n;                // stages at most
} focus;

// A tuning under way.
typedef struct tuning {
    const tune_task *task;
    trial_log *state;
    const char *stage;
    double stage_end; // part of the budget that is used up when it must end
    uint32_t repeats; // launches of a trial that count
    bool keeps_warm;  // a plan that ran before is not warmed up again
    uint32_t first;   // trial that this process measured
    focus focus;
    duet_plan plan; // the variants chosen so far
    uint32_t launches;
    uint32_t unlogged; // trials of the whole device, which the log has no plan for
    uint64_t spent_ns;
    bool found;         // a kernel to be searched
    bool cut;           // the budget ended a search
    duet_error failure; // of the first plan that did not run
} tuning;

// What a trial gave to decide from.
typedef struct trial {
    bool usable;
    search_sample sample;
    uint64_t focus_ns;
    duet_tune_terms terms;
} trial;

static const race_options quick_race = {
    .least_rounds = 4, .most_rounds = 6, .level = 0.85, .dropped = 1};

static const race_options last_race = {
    .least_rounds = 14, .most_rounds = 40, .level = 0.99, .dropped = INFINITY, .margin = 0.03};

// ---------------------------------------------------------------- what is asked

static const char *const default_variants[] = {"auto", "simd", "auto sort=radix", "paper"};

static const char *variant_at(const duet_tune_def *def, uint32_t i)
{
    enum { N_DEFAULT = sizeof default_variants / sizeof *default_variants };
    if (def->n_variants > 0)
        return i < def->n_variants ? def->variants[i] : NULL;
    return i < N_DEFAULT ? default_variants[i] : NULL;
}

static uint32_t count_variants(const duet_tune_def *def)
{
    uint32_t n = 0;
    while (variant_at(def, n))
        ++n;
    return n;
}

// Those that may be searched; some fit no pair of variants.
static uint32_t count_modes(const duet_tune_def *def)
{
    enum { EACH = DUET_MODE_DEFAULT };
    return def->n_modes > 0 && def->n_modes < EACH ? def->n_modes : EACH;
}

// ---------------------------------------------------------------- trials

// Of the first race: all devices alone, and each mode's best share.
static uint32_t most_rivals(const duet_tune_def *def)
{
    return 2 + count_modes(def);
}

uint32_t tune_least_trials(const duet_tune_def *def)
{
    uint32_t variants = count_variants(def);
    return (variants > 1 ? 2 * variants + 2 : 0) + LEAST_SEARCHED * count_modes(def) +
           LEAST_RACED * most_rivals(def) + LEAST_RACED * 2;
}

// What variants, search and verdict take at most.
static uint32_t most_trials(const tuning *t)
{
    const duet_tune_def *def = t->task->def;
    uint32_t variants = count_variants(def), modes = count_modes(def);
    if (def->search)
        return def->budget_trials; // nobody knows how many a search of kernels takes
    uint32_t searched = strategy_find(def->strategy)->launches;
    uint32_t most = (variants > 1 ? 2 * variants * quick_race.most_rounds + 2 : 0) +
                    modes * searched + most_rivals(def) * race_default_options().most_rounds +
                    3 * last_race.most_rounds +
                    (t->task->whole.open ? 2 * race_default_options().most_rounds : 0);
    return def->budget_trials > 0 && def->budget_trials < most ? def->budget_trials : most;
}

// Trials at which the stage must end.
static double last_trial(const tuning *t)
{
    const duet_tune_def *def = t->task->def;
    double all = def->budget_trials;
    double raced = all - (t->task->whole.open ? LEAST_RACED * 2 : 0);
    double searched = fmin(SEARCH_END * raced, raced - LEAST_RACED * most_rivals(def));
    if (t->stage_end <= SEARCH_END)
        return t->stage_end / SEARCH_END * searched;
    return t->stage_end < ALL ? raced : all;
}

// Of the stage.
static bool within_budget(const tuning *t)
{
    const duet_tune_def *def = t->task->def;
    bool in_time =
        def->budget_seconds <= 0 || (double)t->spent_ns * 1e-9 < t->stage_end * def->budget_seconds;
    return in_time && (def->budget_trials == 0 || t->state->played + t->unlogged < last_trial(t));
}

// What trials at least take, each half as long as one device alone, says after the
// first of them, whose kernels were built in it, whether the time can do.
static bool check_budget(const tuning *t, const trial *first, duet_error *err)
{
    const duet_tune_def *def = t->task->def;
    double launch_s = (double)first->sample.total_ns * 1e-9;
    double least_s = (double)t->spent_ns * 1e-9 +
                     0.5 * launch_s * (1 + VERDICT_REPEATS) * tune_least_trials(def);
    return def->budget_seconds <= 0 || least_s <= def->budget_seconds ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "a budget of %.3g s ends before a verdict: a step takes %.3g s; expected at "
                     "least %.3g s",
                     def->budget_seconds, launch_s, ceil(least_s));
}

static bool stop(const tuning *t, duet_error *err)
{
    return error_set(err, DUET_STATUS_INTERRUPTED,
                     "stopped after %u trials; the same command goes on from there",
                     t->state->played);
}

static bool tell_watcher(const tuning *t, const trial_log_entry *entry, bool remembered,
                         duet_error *err)
{
    const duet_tune_def *def = t->task->def;
    duet_tune_progress progress = {
        .stage = t->stage,
        .plan = &entry->plan,
        .ms = (double)entry->sample.total_ns * 1e-6,
        .trials = t->state->played + t->unlogged,
        .most_trials = most_trials(t),
        .launches = t->launches,
        .seconds = (double)t->spent_ns * 1e-9,
        .remembered = remembered,
    };
    return !def->watch || def->watch(def->watch_context, &progress) || stop(t, err);
}

static trial_log_entry entry_of(const tuning *t, const duet_plan *plan, const measurement *m)
{
    const profile_sample *typical = &m->samples[m->typical];
    trial_log_entry entry = {
        .plan = *plan,
        .usable = strcmp(m->outcome, "ok") == 0,
        .sample = {.share = plan->share},
        .launches = m->n_samples,
        .spent_ns = m->spent_ns,
    };
    if (entry.usable) {
        entry.sample.total_ns = (uint64_t)typical->total_ns;
        entry.sample.a_ns = (uint64_t)typical->a_ns;
        entry.sample.b_ns = (uint64_t)typical->b_ns;
        entry.terms = m->launch.terms;
        if (t->focus.stages)
            entry.focus_ns =
                measure_stages_ns(&m->launch, t->focus.device, t->focus.stages, t->focus.n);
    }
    return entry;
}

static bool has_default_variants(const tune_task *task, const duet_plan *plan)
{
    return strcmp(plan->variant_a, task->plan.variant_a) == 0 &&
           strcmp(plan->variant_b, task->plan.variant_b) == 0;
}

// The default variants must be right; any other that is wrong is passed over.
static bool check_measured(tuning *t, const duet_plan *plan, const measurement *m, duet_error *err)
{
    if (strcmp(m->outcome, "ok") == 0)
        return true;
    error_set(&t->failure, m->failure.status, "no plan runs: %s", m->failure.text);
    if (strcmp(m->outcome, "wrong") == 0 && has_default_variants(t->task, plan))
        return error_set(err, DUET_STATUS_WRONG_RESULT,
                         "share %u of %u, variants '%s' and '%s': %s", plan->share, DUET_SHARE_ONE,
                         plan->variant_a, plan->variant_b, m->failure.text);
    return true;
}

// Its programs are built, for it ran in this process.
static bool is_warm(const tuning *t, const duet_plan *plan)
{
    bool warm = false;
    for (uint32_t i = t->first; t->keeps_warm && i < t->state->played && !warm; ++i)
        warm = trial_log_same_plan(&t->state->entries[i].plan, plan);
    return warm;
}

static bool measure_live(tuning *t, const duet_plan *plan, trial_log_entry *entry, duet_error *err)
{
    const tune_task *task = t->task;
    if (!budget_check(err))
        return false;
    measurement m = measure_plan(&task->machine, plan, is_warm(t, plan), t->repeats);
    if (m.failure.status == DUET_STATUS_INTERRUPTED)
        return stop(t, err);
    *entry = entry_of(t, plan, &m);
    if (!trial_log_add(t->state, entry, err))
        return false;
    ++t->state->played;
    const tune_recorder *recorder = &task->recorder;
    return (!recorder->trial || recorder->trial(recorder->context, plan, &m, t->state, err)) &&
           check_measured(t, plan, &m, err);
}

// From the log, or else from the machine.
static bool run_trial(tuning *t, const duet_plan *plan, trial *out, duet_error *err)
{
    const trial_log_entry *kept = trial_log_next(t->state, plan);
    trial_log_entry entry;
    *out = (trial){0};
    if (kept)
        entry = *kept;
    else if (!measure_live(t, plan, &entry, err))
        return false;
    t->first = kept ? t->state->played : t->first;
    t->launches += entry.launches;
    t->spent_ns += entry.spent_ns;
    out->usable = entry.usable;
    out->sample = entry.sample;
    out->focus_ns = entry.focus_ns;
    out->terms = entry.terms;
    return tell_watcher(t, &entry, kept, err) &&
           (t->state->played > 1 || check_budget(t, out, err));
}

// The chosen variants at a share.
static duet_plan plan_at(const tuning *t, uint32_t share, duet_mode mode)
{
    duet_plan plan = t->plan;
    plan.share = share;
    plan.mode = mode;
    return plan;
}

// ---------------------------------------------------------------- races

// Plans in a race, with the terms of each one's last trial.
typedef struct field {
    duet_plan plans[RACE_RIVALS];
    duet_tune_terms terms[RACE_RIVALS];
    uint32_t n;
    race race;
} field;

static void enter(field *f, duet_plan plan)
{
    if (f->n < RACE_RIVALS)
        f->plans[f->n++] = plan;
}

// What is so much slower is not worth another round.
static void drop_hopeless(race *r, double hopeless)
{
    uint32_t leader = race_leader(r);
    for (uint32_t i = 0; i < r->n && leader < r->n; ++i) {
        if (r->rivals[i].rounds > 0 && race_compare(r, leader, i).ratio > hopeless)
            race_drop(r, i);
    }
}

// What of a launch is compared: the stages in focus, or A's part, or the step.
static double time_of(const tuning *t, const trial *got, bool of_a)
{
    uint64_t step = of_a ? got->sample.a_ns : got->sample.total_ns;
    return (double)(t->focus.stages ? got->focus_ns : step);
}

// Races until it is decided or the stage's part of the budget is spent. A
// trial's time is the total, or A's own where that is what is chosen. Who takes
// `hopeless` times the leader's time runs no more.
static bool run_race(tuning *t, field *f, const race_options *options, bool of_a, double hopeless,
                     duet_error *err)
{
    uint32_t rival;
    f->race = race_begin(f->n, options);
    while (within_budget(t) && race_next(&f->race, &rival)) {
        trial got;
        if (!run_trial(t, &f->plans[rival], &got, err))
            return false;
        if (got.usable)
            race_add(&f->race, rival, time_of(t, &got, of_a));
        else
            race_drop(&f->race, rival);
        drop_hopeless(&f->race, hopeless);
        f->terms[rival] = got.terms;
    }
    return true;
}

// ---------------------------------------------------------------- variants

static void set_variant(duet_plan *plan, int device, const char *variant)
{
    char *to = device == 0 ? plan->variant_a : plan->variant_b;
    snprintf(to, sizeof plan->variant_a, "%s", variant);
}

// Races the variants of one device at a share; the best one enters the plan.
static bool choose_variant(tuning *t, int device, uint32_t share, duet_error *err)
{
    field f = {0};
    const char *variant;
    for (uint32_t i = 0; (variant = variant_at(t->task->def, i)); ++i) {
        duet_plan plan = plan_at(t, share, DUET_MODE_OWN);
        set_variant(&plan, device, variant);
        enter(&f, plan);
    }
    if (!run_race(t, &f, &quick_race, device == 0, HOPELESS, err))
        return false;
    uint32_t leader = race_leader(&f.race);
    if (leader < f.n)
        set_variant(&t->plan, device,
                    device == 0 ? f.plans[leader].variant_a : f.plans[leader].variant_b);
    return true;
}

// As much work for A as it does in the time that B needs for all of it: its
// variants are compared there without an expensive launch.
static bool find_share_of_a(tuning *t, uint32_t *share, duet_error *err)
{
    trial whole, part;
    duet_plan b_alone = plan_at(t, 0, DUET_MODE_OWN);
    duet_plan probe = plan_at(t, DUET_SHARE_ONE / 16, DUET_MODE_OWN);
    *share = probe.share;
    if (!run_trial(t, &b_alone, &whole, err) || !run_trial(t, &probe, &part, err))
        return false;
    if (whole.usable && part.usable && part.sample.a_ns > 0) {
        double fits = (double)whole.sample.total_ns / (double)part.sample.a_ns;
        *share = (uint32_t)(probe.share * fmin(fmax(fits, 1), 16));
    }
    return true;
}

static bool choose_variants(tuning *t, duet_error *err)
{
    uint32_t share;
    for (int device = 0; device < 2; ++device)
        set_variant(&t->plan, device, variant_at(t->task->def, 0));
    if (!variant_at(t->task->def, 1))
        return true;
    t->stage_end = VARIANTS_END;
    t->stage = "variant of B";
    if (!choose_variant(t, 1, 0, err))
        return false;
    if (t->task->one_device) {
        set_variant(&t->plan, 0, t->plan.variant_b);
        return true;
    }
    t->stage = "variant of A";
    return find_share_of_a(t, &share, err) && choose_variant(t, 0, share, err);
}

// ---------------------------------------------------------------- kernels

static const char *variant_of(const duet_plan *plan, int device)
{
    return device == 0 ? plan->variant_a : plan->variant_b;
}

// The configs as plans; one whose text would be too long is left out.
static uint32_t enter_configs(const duet_plan *plan, int device, const kernel_space *space,
                              uint32_t *configs, uint32_t n, field *f)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; ++i) {
        duet_plan with = *plan;
        char *to = device == 0 ? with.variant_a : with.variant_b;
        if (!kernel_space_write(space, configs[i], variant_of(plan, device), to, DUET_VARIANT))
            continue;
        enter(f, with);
        configs[kept++] = configs[i];
    }
    return kept;
}

// Drops what is so much slower than the fastest; returns how many are left.
static uint32_t drop_slower(double *times, bool *out, uint32_t n, double slower)
{
    double least = INFINITY;
    uint32_t left = 0;
    for (uint32_t i = 0; i < n; ++i)
        least = fmin(least, times[i]);
    for (uint32_t i = 0; i < n; ++i) {
        out[i] = out[i] || !(times[i] <= slower * least);
        left += !out[i];
    }
    return left;
}

// Launches the configs in turn, round by round, and leaves out who is behind, sooner the
// further. A config's time is the least that its kernel took, by the device's own clock:
// what disturbs a launch only adds to it. INFINITY for one that did not run.
static bool screen_configs(tuning *t, const field *f, double times[KERNEL_SPACE_VALUES],
                           duet_error *err)
{
    static const double slower[] = {1.1, 1.03};
    bool out[KERNEL_SPACE_VALUES] = {false};
    uint32_t left = f->n;
    for (uint32_t i = 0; i < f->n; ++i)
        times[i] = INFINITY;
    for (size_t round = 0; left > 1 && round < sizeof slower / sizeof *slower; ++round) {
        for (uint32_t k = 0; k < f->n; ++k) {
            uint32_t i = (k + (uint32_t)round) % f->n;
            trial got;
            if (out[i] || !within_budget(t))
                continue;
            if (!run_trial(t, &f->plans[i], &got, err))
                return false;
            if (got.usable)
                times[i] = fmin(times[i], (double)got.focus_ns);
        }
        left = drop_slower(times, out, f->n, slower[round]);
    }
    return true;
}

// Whether the kernel takes enough of its device's time for a search to pay.
static bool is_worth_search(tuning *t, const duet_plan *plan, int device, bool *worth,
                            duet_error *err)
{
    trial got;
    if (!run_trial(t, plan, &got, err))
        return false;
    double whole = (double)(device == 0 ? got.sample.a_ns : got.sample.b_ns);
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
    if (!is_worth_search(t, plan, device, &worth, err))
        return false;
    while (worth && within_budget(t) && (n = kernel_search_next(&s, configs)) > 0) {
        field f = {0};
        n = enter_configs(plan, device, space, configs, n, &f);
        if (!screen_configs(t, &f, times, err))
            return false;
        kernel_search_tell(&s, configs, times, n);
    }
    told->configs += worth ? space->n_configs : 0;
    told->tried += worth ? s.tried : 0;
    char variant[DUET_VARIANT];
    if (kernel_space_write(space, s.best, variant_of(plan, device), variant, sizeof variant))
        set_variant(plan, device, variant);
    return true;
}

// What was found against what was there, by all kernels of the device. Only what is
// faster for sure is used.
static bool confirm_kernels(tuning *t, int device, const duet_plan *before, const duet_plan *after,
                            duet_kernel_search *told, duet_error *err)
{
    static const race_options to_the_end = {
        .least_rounds = 10, .most_rounds = 24, .level = 0.99, .dropped = INFINITY, .margin = 0.02};
    static const char *const stages[] = {"search", "candidates", "narrow",     "reorder", "bounds",
                                         "hash",   "sort",       "cell start", "clear"};
    race_gain gain = {.verdict = RACE_SAME, .ratio = 1, .interval = {1, 1, 1}};
    t->focus = (focus){device, stages, sizeof stages / sizeof *stages};
    if (!trial_log_same_plan(before, after)) {
        field f = {0};
        enter(&f, *before);
        enter(&f, *after);
        if (!run_race(t, &f, &to_the_end, false, INFINITY, err))
            return false;
        gain.verdict = RACE_AMBIGUOUS;
        if (f.race.rivals[0].rounds > 0 && f.race.rivals[1].rounds > 0)
            gain = race_compare(&f.race, 1, 0);
    }
    if (gain.verdict == RACE_FASTER)
        set_variant(&t->plan, device, variant_of(after, device));
    told->gain = gain.ratio - 1;
    told->gain_low = gain.interval.low - 1;
    told->gain_high = gain.interval.high - 1;
    snprintf(told->verdict, sizeof told->verdict, "%s", race_verdict_name(gain.verdict));
    return true;
}

static bool is_meant(const char *what, const kernel_space *space)
{
    return strcmp(what, "kernels") == 0 || strcmp(what, space->kernel) == 0;
}

static bool search_device(tuning *t, int device, uint32_t share, duet_kernel_search *told,
                          duet_error *err)
{
    const tune_kernels *kernels = &t->task->kernels;
    kernel_space *spaces = NULL;
    uint32_t n = 0, launches = t->launches;
    trial got;
    duet_plan before = plan_at(t, share, DUET_MODE_OWN), after = before;
    if (!run_trial(t, &before, &got, err))
        return false;
    t->found |= !got.usable; // the verdict tells why
    bool ok = !got.usable || kernels->read(kernels->context, &before, device, &spaces, &n, err);
    for (uint32_t i = 0; ok && i < n && within_budget(t); ++i) {
        if (!is_meant(t->task->def->search, &spaces[i]))
            continue;
        t->found = true;
        ok = search_kernel(t, device, &spaces[i], &after, told, err);
    }
    free(spaces);
    told->launches = t->launches - launches;
    ok = ok && confirm_kernels(t, device, &before, &after, told, err);
    t->focus.stages = NULL;
    return ok;
}

// What a search led to on this device beside another one, if it is a variant that may
// be chosen.
static bool take_searched(tuning *t, int device)
{
    const char *searched = t->task->searched[device], *base;
    bool taken = false;
    for (uint32_t i = 0; *searched && !taken && (base = variant_at(t->task->def, i)); ++i) {
        size_t length = strlen(base);
        taken = strncmp(searched, base, length) == 0 &&
                (searched[length] == '\0' || searched[length] == ' ');
    }
    if (taken)
        set_variant(&t->plan, device, searched);
    t->found |= taken;
    return taken;
}

// The kernels of B doing all the work, then of A doing as much as it does meanwhile. A
// launch of a plan that ran before needs none to warm up, and each counts.
static bool search_kernels(tuning *t, duet_kernel_search told[2], duet_error *err)
{
    uint32_t repeats = t->repeats, share;
    if (!t->task->def->search)
        return true;
    t->stage = "kernels of B";
    t->stage_end = (VARIANTS_END + KERNELS_END) / 2;
    t->keeps_warm = true;
    t->repeats = 1;
    bool ok = take_searched(t, 1) || !within_budget(t) || search_device(t, 1, 0, &told[1], err);
    t->stage = "kernels of A";
    t->stage_end = KERNELS_END;
    if (t->task->one_device)
        set_variant(&t->plan, 0, t->plan.variant_b);
    else
        ok = ok && (take_searched(t, 0) || !within_budget(t) ||
                    (find_share_of_a(t, &share, err) && search_device(t, 0, share, &told[0], err)));
    t->keeps_warm = false;
    t->repeats = repeats;
    if (ok && !t->found && within_budget(t))
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "search '%s': neither device runs it with several configs by '%s' and "
                         "'%s'",
                         t->task->def->search, t->plan.variant_a, t->plan.variant_b);
    return ok;
}

// ---------------------------------------------------------------- share

// What the search of one mode came to.
typedef struct found {
    duet_mode mode;
    bool usable;
    uint32_t share;
    double a_alone_ns; // expected; INFINITY where nothing was seen of A
    double b_alone_ns; // as measured first
} found;

// A's time for all the work, from the least and the largest part that it did.
static double expect_a_alone(const search *s)
{
    const search_sample *small = NULL, *large = NULL;
    for (uint32_t i = 0; i < s->n; ++i) {
        const search_sample *at = &s->samples[i];
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

static bool run_search(tuning *t, search *s, duet_mode mode, bool *usable, duet_error *err)
{
    *usable = true;
    while (*usable) {
        search_next next;
        trial got;
        if (!search_ask(s, &next, err))
            return false;
        t->cut |= !next.done && !within_budget(t);
        if (next.done || t->cut)
            return true;
        duet_plan plan = plan_at(t, next.share, mode);
        if (!run_trial(t, &plan, &got, err))
            return false;
        got.sample.share = next.share;
        *usable = got.usable;
        if (got.usable && !search_tell(s, &got.sample, err))
            return false;
    }
    return true;
}

// near: a share to begin from, or NULL.
static bool search_mode(tuning *t, duet_mode mode, const uint32_t *near, found *out,
                        duet_error *err)
{
    search s;
    search_options options = search_default_options();
    options.quantum = t->task->least_share;
    options.has_start = near;
    options.start = near ? *near : 0;
    if (!search_begin(&s, t->task->def->strategy, &options, err))
        return false;
    s.script = t->task->script;
    bool ok = run_search(t, &s, mode, &out->usable, err);
    out->mode = mode;
    out->usable = out->usable && s.n > 0;
    out->share = search_pick(&s);
    // Of a search that was cut short one device alone may only seem the best.
    if (t->cut && (out->share == 0 || out->share == DUET_SHARE_ONE))
        out->share = search_first_share(&s);
    out->a_alone_ns = expect_a_alone(&s);
    out->b_alone_ns = s.n > 0 && search_at(&s, 0) ? (double)search_at(&s, 0)->total_ns : INFINITY;
    search_end(&s);
    return ok;
}

// One device's grid is of no use to the other where they search differently.
static bool mode_fits(const duet_plan *plan, duet_mode mode)
{
    size_t a = strcspn(plan->variant_a, " "), b = strcspn(plan->variant_b, " ");
    return mode == DUET_MODE_OWN || mode == DUET_MODE_SLAB ||
           (mode == DUET_MODE_SHARED && a == b &&
            strncmp(plan->variant_a, plan->variant_b, a) == 0);
}

static uint32_t list_modes(const tuning *t, duet_mode modes[MOST_MODES])
{
    const duet_tune_def *def = t->task->def;
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

// Each mode is searched from the share that was best in the one before.
static bool search_modes(tuning *t, found founds[MOST_MODES], uint32_t *n, duet_error *err)
{
    duet_mode modes[MOST_MODES];
    const uint32_t *near = t->task->has_start ? &t->task->start : NULL;
    *n = t->task->one_device ? 0 : list_modes(t, modes);
    t->stage = "share";
    for (uint32_t i = 0; i < *n; ++i) {
        double from = t->task->def->search ? KERNELS_END : VARIANTS_END;
        t->stage_end = from + (SEARCH_END - from) * (i + 1) / *n;
        if (!search_mode(t, modes[i], near, &founds[i], err))
            return false;
        near = founds[i].usable ? &founds[i].share : near;
    }
    return true;
}

// ---------------------------------------------------------------- verdict

// First all rivals race, for the better single device and the best shared plan.
// Then these two run against each other, and only that counts: samples from
// which the best of several was chosen make it look better than it is.
//
// A round is short, so that a slow while of the machine falls on all rivals
// alike. What takes a core away for a moment hits two of them twice as often as
// one: the quicker of two launches counts.
// The devices alone come first, then the best share of each mode.
static uint32_t enter_rivals(const tuning *t, const found *founds, uint32_t n, field *f)
{
    double a_alone_ns = INFINITY, b_alone_ns = INFINITY;
    for (uint32_t i = 0; i < n; ++i) {
        a_alone_ns = fmin(a_alone_ns, founds[i].a_alone_ns);
        b_alone_ns = fmin(b_alone_ns, founds[i].b_alone_ns);
    }
    enter(f, plan_at(t, 0, DUET_MODE_OWN));
    if (a_alone_ns < WORTH_ALONE * b_alone_ns)
        enter(f, plan_at(t, DUET_SHARE_ONE, DUET_MODE_OWN));
    uint32_t n_alone = f->n;
    for (uint32_t i = 0; i < n; ++i) {
        if (founds[i].usable && founds[i].share > 0 && founds[i].share < DUET_SHARE_ONE)
            enter(f, plan_at(t, founds[i].share, founds[i].mode));
    }
    return n_alone;
}

// Both devices' undisturbed times in all trials of a plan; false where there
// are too few.
static bool undisturbed(const trial_log *state, const duet_plan *plan, double ns[2])
{
    double times[2][STATS_MOST];
    uint32_t n = 0;
    for (uint32_t i = 0; i < state->played && n < STATS_MOST; ++i) {
        const trial_log_entry *entry = &state->entries[i];
        if (!entry->usable || !trial_log_same_plan(&entry->plan, plan))
            continue;
        times[0][n] = (double)entry->sample.a_ns;
        times[1][n++] = (double)entry->sample.b_ns;
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
    if (!strategy_find(t->task->def->strategy)->evened || !undisturbed(t->state, plan, ns))
        return false;
    double part = (double)plan->share / DUET_SHARE_ONE;
    double a = ns[0] / part, b = ns[1] / (1 - part); // for all the work
    double fair = b / (a + b);
    double quanta = floor(fair * DUET_SHARE_ONE / t->task->least_share + 0.5);
    *even = *plan;
    even->share = (uint32_t)quanta * t->task->least_share;
    return fmax(ns[0], ns[1]) > UNEVEN * fair * a && even->share > 0 &&
           even->share < DUET_SHARE_ONE;
}

static uint32_t fewer_rounds(const race *r, uint32_t rival, uint32_t other)
{
    uint32_t n = r->rivals[rival].rounds, m = r->rivals[other].rounds;
    return n < m ? n : m;
}

static void judge(const tuning *t, const field *f, uint32_t alone, uint32_t best,
                  duet_tune_outcome *outcome)
{
    race_gain gain = {
        .verdict = t->cut ? RACE_AMBIGUOUS : RACE_SAME, .ratio = 1, .interval = {1, 1, 1}};
    if (best != alone)
        gain = race_compare(&f->race, best, alone);
    uint32_t use = gain.verdict == RACE_FASTER ? best : alone;
    outcome->best = f->plans[best];
    outcome->plan = f->plans[use];
    outcome->terms = f->terms[best];
    outcome->gain = gain.ratio - 1;
    outcome->gain_low = gain.interval.low - 1;
    outcome->gain_high = gain.interval.high - 1;
    outcome->rounds = best == alone ? 0 : fewer_rounds(&f->race, best, alone);
    snprintf(outcome->verdict, sizeof outcome->verdict, "%s", race_verdict_name(gain.verdict));
    stats_interval in =
        stats_median_interval(f->race.rivals[use].ns, f->race.rivals[use].rounds, 0.95);
    outcome->step_ms = race_median(&f->race, use) * 1e-6;
    outcome->step_low_ms = in.low * 1e-6;
    outcome->step_high_ms = in.high * 1e-6;
    outcome->single_ms = race_median(&f->race, alone) * 1e-6;
}

static bool fail_unmeasured(const tuning *t, duet_error *err)
{
    if (t->failure.status == DUET_STATUS_OK)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the budget ended before the devices were compared; expected more "
                         "than %u trials or %.3g seconds",
                         t->state->played, (double)t->spent_ns * 1e-9);
    if (err && err->status == DUET_STATUS_OK)
        *err = t->failure;
    return false;
}

// The single device and the shared plan once more, with its evened share.
static bool race_finalists(tuning *t, const duet_plan *alone, const duet_plan *shared, field *f,
                           duet_error *err)
{
    duet_plan even;
    *f = (field){0};
    enter(f, *alone);
    enter(f, *shared);
    if (even_out(t, shared, &even))
        enter(f, even);
    return run_race(t, f, &last_race, false, INFINITY, err);
}

// The budget may have ended before or in this race: then the first one's samples
// must do.
static bool is_decided(const field *f, uint32_t best)
{
    return best < f->n && f->race.rivals[0].rounds > 0 &&
           race_compare(&f->race, best, 0).verdict != RACE_AMBIGUOUS;
}

// Without a rival: the time of a step, and its interval.
static bool run_alone(tuning *t, field *f, duet_error *err)
{
    f->race = race_begin(f->n, NULL);
    for (uint32_t i = 0; i < LEAST_RACED && within_budget(t); ++i) {
        trial got;
        if (!run_trial(t, &f->plans[0], &got, err))
            return false;
        if (got.usable)
            race_add(&f->race, 0, (double)got.sample.total_ns);
        f->terms[0] = got.terms;
    }
    return true;
}

// The best of what was found, raced against the better single device. What does
// not prove to be faster is not used: tuned is never slower than one device.
static bool reach_verdict(tuning *t, const found *founds, uint32_t n, duet_tune_outcome *outcome,
                          duet_error *err)
{
    field all = {0}, finalists;
    uint32_t n_alone = enter_rivals(t, founds, n, &all);
    t->stage = "verdict";
    t->stage_end = t->task->whole.open ? VERDICT_END : ALL;
    t->repeats = t->repeats < VERDICT_REPEATS ? t->repeats : VERDICT_REPEATS;
    if (!(all.n > 1 ? run_race(t, &all, NULL, false, INFINITY, err) : run_alone(t, &all, err)))
        return false;
    uint32_t alone = race_best(&all.race, 0, n_alone);
    uint32_t shared = race_best(&all.race, n_alone, all.n);
    if (alone == n_alone)
        return fail_unmeasured(t, err);
    if (shared == all.n) {
        judge(t, &all, alone, alone, outcome);
        return true;
    }
    if (!race_finalists(t, &all.plans[alone], &all.plans[shared], &finalists, err))
        return false;
    uint32_t best = race_best(&finalists.race, 1, finalists.n);
    if (is_decided(&finalists, best))
        judge(t, &finalists, 0, best, outcome);
    else
        judge(t, &all, alone, shared, outcome);
    return true;
}

// ---------------------------------------------------------------- the undivided device

// A trial of the plan to use on its two devices, or of the undivided one. No log
// keeps it: a resumed tuning runs this race again.
static bool run_unlogged(tuning *t, const measure_machine *machine, const duet_plan *plan,
                         double *ns, duet_error *err)
{
    measurement m = measure_plan(machine, plan, false, t->repeats);
    if (m.failure.status == DUET_STATUS_INTERRUPTED)
        return stop(t, err);
    trial_log_entry entry = entry_of(t, plan, &m);
    ++t->unlogged;
    t->launches += entry.launches;
    t->spent_ns += entry.spent_ns;
    *ns = entry.usable ? (double)entry.sample.total_ns : 0;
    return tell_watcher(t, &entry, false, err);
}

// Two parts of a device are worth opening only where they are not slower than all
// of it.
static bool race_whole(tuning *t, duet_tune_outcome *outcome, duet_error *err)
{
    const tune_whole *whole = &t->task->whole;
    measure_machine machines[2] = {t->task->machine};
    duet_plan plans[2] = {outcome->plan};
    race r = race_begin(2, NULL);
    uint32_t rival;
    if (!whole->open)
        return true;
    if (!whole->open(whole->context, outcome->plan.variant_b, &machines[1], &plans[1]))
        return budget_check_stop(NULL) || stop(t, err);
    t->stage = "undivided";
    t->stage_end = ALL;
    while (within_budget(t) && race_next(&r, &rival)) {
        double ns = 0;
        if (!run_unlogged(t, &machines[rival], &plans[rival], &ns, err))
            return false;
        if (ns <= 0)
            return true;
        race_add(&r, rival, ns);
    }
    if (fewer_rounds(&r, 0, 1) < LEAST_RACED)
        return true;
    race_gain gain = race_compare(&r, 0, 1);
    outcome->whole_ms = race_median(&r, 1) * 1e-6;
    outcome->whole_gain = gain.ratio - 1;
    outcome->whole_gain_low = gain.interval.low - 1;
    outcome->whole_gain_high = gain.interval.high - 1;
    return true;
}

// ---------------------------------------------------------------- the whole tuning

bool tune_run(const tune_task *task, trial_log *state, duet_tune_outcome *outcome, duet_error *err)
{
    tuning t = {.task = task, .state = state, .plan = task->plan, .repeats = task->def->repeats};
    found founds[MOST_MODES] = {0};
    uint32_t n = 0;
    state->played = 0;
    *outcome = (duet_tune_outcome){0};
    bool ok = choose_variants(&t, err) && search_kernels(&t, outcome->kernels, err) &&
              search_modes(&t, founds, &n, err) && reach_verdict(&t, founds, n, outcome, err) &&
              race_whole(&t, outcome, err);
    outcome->trials = state->played + t.unlogged;
    outcome->launches = t.launches;
    outcome->seconds = (double)t.spent_ns * 1e-9;
    return ok;
}
