// SPDX-License-Identifier: MIT
#include "tuner/replay.h"

#include "runtime/broadphase/variant.h"
#include "tuner/stats.h"
#include "tuner/strategy.h"
#include "tuner/tune.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDEST_GAP = DUET_SHARE_ONE / 16 }; // between shares that are interpolated

// ---------------------------------------------------------------- points

static bool is_alone(uint32_t share)
{
    return share == 0 || share == DUET_SHARE_ONE;
}

static bool same_point(const profile_launch *a, const profile_launch *b)
{
    return a->share == b->share && strcmp(a->mode, b->mode) == 0 &&
           strcmp(a->variant_a, b->variant_a) == 0 && strcmp(a->variant_b, b->variant_b) == 0;
}

// Launches are ordered by total_ns.
static double median_ns(const replay_point *p)
{
    const profile_launch *of = p->launches[0];
    return ((double)of[(p->n[0] - 1) / 2].total_ns + (double)of[p->n[0] / 2].total_ns) / 2;
}

static void add_mode(replay *r, const duet_plan *plan)
{
    bool known = r->n_modes > 0 && r->modes[r->n_modes - 1] == plan->mode;
    if (!is_alone(plan->share) && !known)
        r->modes[r->n_modes++] = plan->mode;
}

// Adds the point of the n launches of one plan.
static void add_point(replay *r, const profile_launch *launches, uint32_t n)
{
    uint32_t counted = 0;
    while (counted < n && !launches[counted].warm_up)
        ++counted;
    replay_point p = {
        .plan.share = launches->share,
        .launches = {launches, launches + counted},
        .n = {counted, n - counted},
    };
    if (counted == 0 || !mode_from_name(launches->mode, &p.plan.mode) ||
        p.plan.mode == DUET_MODE_DEFAULT)
        return;
    plan_set_variant(&p.plan, 0, launches->variant_a);
    plan_set_variant(&p.plan, 1, launches->variant_b);
    p.median_ns = median_ns(&p);
    add_mode(r, &p.plan);
    replay_point *kept = &r->points[r->n_points++];
    *kept = p;
    r->best = !r->best || p.median_ns < r->best->median_ns ? kept : r->best;
}

static void add_points(replay *r, uint32_t n)
{
    for (uint32_t from = 0, to; from < n; from = to) {
        for (to = from + 1; to < n && same_point(&r->launches[from], &r->launches[to]);)
            ++to;
        add_point(r, &r->launches[from], to - from);
    }
}

static bool read_spaces(replay *r, duet_error *err)
{
    r->spaces = calloc(2, sizeof *r->spaces);
    if (!r->spaces)
        return no_memory(err, "recorded kernels");
    for (uint32_t i = 0; i < 2 * r->n_points; ++i)
        if (*plan_variant(&r->points[i / 2].plan, i % 2))
            recorded_space_add(&r->spaces[i % 2], plan_variant(&r->points[i / 2].plan, i % 2));
    for (uint32_t i = 0; i < r->n_points; ++i) {
        if (*r->points[i].plan.variant_a)
            recorded_space_order(&r->spaces[0], r->points[i].plan.variant_a);
        if (*r->points[i].plan.variant_b)
            recorded_space_order(&r->spaces[1], r->points[i].plan.variant_b);
    }
    return true;
}

bool replay_open(replay *r, store *s, const profile_surface *surface, duet_error *err)
{
    uint32_t n = 0;
    *r = (replay){.surface = surface};
    if (!profile_surface_launches(s, surface, &r->launches, &n, err))
        return false;
    r->points = calloc((size_t)n + 1, sizeof *r->points);
    if (!r->points)
        return no_memory(err, "%u recorded launches", n);
    add_points(r, n);
    return !surface->joint || read_spaces(r, err);
}

void replay_close(replay *r)
{
    free(r->spaces);
    free(r->points);
    free(r->launches);
    *r = (replay){0};
}

// ---------------------------------------------------------------- launches

// The points that stand for a plan: part `weight` of `high` and the rest of `low`.
typedef struct between {
    const replay_point *low;
    const replay_point *high;
    double weight;
} between;

// Whether the devices that work run the same kernels: all do, unless the surface is joint.
static bool has_kernels(const replay *r, const replay_point *p, const duet_plan *plan)
{
    bool a = plan->share > 0, b = plan->share < DUET_SHARE_ONE;
    return !r->surface->joint || ((!a || strcmp(p->plan.variant_a, plan->variant_a) == 0) &&
                                  (!b || strcmp(p->plan.variant_b, plan->variant_b) == 0));
}

// The nearest points at or below a share of a mode and at or above it, at which as many devices
// work, with the same kernels; NULL if there is none.
static between find_neighbours(const replay *r, const duet_plan *plan)
{
    between at = {0};
    for (uint32_t i = 0; i < r->n_points; ++i) {
        const replay_point *p = &r->points[i];
        bool fits = is_alone(plan->share) ? p->plan.share == plan->share
                                          : p->plan.mode == plan->mode && !is_alone(p->plan.share);
        if (!fits || !has_kernels(r, p, plan))
            continue;
        if (p->plan.share <= plan->share)
            at.low = p;
        if (p->plan.share >= plan->share && !at.high)
            at.high = p;
    }
    return at;
}

static between find_points(const replay *r, const duet_plan *plan)
{
    between at = find_neighbours(r, plan);
    at.low = at.low ? at.low : at.high;
    at.high = at.high ? at.high : at.low;
    if (!at.low || at.low == at.high)
        return at;
    uint32_t low = at.low->plan.share, gap = at.high->plan.share - low;
    at.weight = (double)(plan->share - low) / gap;
    if (gap > WIDEST_GAP)
        at.weight = round(at.weight);
    return at;
}

// rank: 0 for the quickest launch, below 1 for the slowest one.
static const profile_launch *launch_of(const replay_point *p, bool warms_up, double rank)
{
    bool from = warms_up && p->n[1] > 0;
    return &p->launches[from][(uint32_t)(rank * p->n[from])];
}

static double mix(int64_t low, int64_t high, double weight)
{
    return (1 - weight) * (double)low + weight * (double)high;
}

static int64_t slower_ns(const profile_launch *launch)
{
    return launch->a_ns > launch->b_ns ? launch->a_ns : launch->b_ns;
}

// Mixes the times of both devices, and the time that a step takes beyond the slower device. A
// step's own time bends at the share at which the slower device changes, which a line between two
// shares would cut off.
static profile_launch mix_launches(const between *at, bool warms_up, double rank)
{
    const profile_launch *low = launch_of(at->low, warms_up, rank);
    const profile_launch *high = launch_of(at->high, warms_up, rank);
    double rest = mix(low->total_ns - slower_ns(low), high->total_ns - slower_ns(high), at->weight);
    profile_launch launch = {.a_ns = llround(mix(low->a_ns, high->a_ns, at->weight)),
                             .b_ns = llround(mix(low->b_ns, high->b_ns, at->weight))};
    launch.total_ns = (int64_t)fmax(1, round((double)slower_ns(&launch) + rest));
    return launch;
}

double replay_median_ns(const replay *r, const duet_plan *plan)
{
    enum { RANKS = 101 };
    double totals[RANKS];
    between at = find_points(r, plan);
    if (!at.low || at.low == at.high)
        return at.low ? at.low->median_ns : NAN;
    for (int i = 0; i < RANKS; ++i)
        totals[i] = (double)mix_launches(&at, false, (i + 0.5) / RANKS).total_ns;
    return stats_median(totals, RANKS);
}

// Takes a staged launch for the warm-up: a tuning that does not time stages stages no other.
static bool launch_recorded(void *context, const duet_plan *plan, bool staged,
                            measure_launch *launch, duet_error *err)
{
    replay *r = context;
    between at = find_points(r, plan);
    double rank = rng_unit(&r->random);
    if (!at.low)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "mode '%s' with '%s' and '%s' was not recorded",
                         duet_mode_name(plan->mode), plan->variant_a, plan->variant_b);
    profile_launch drawn = mix_launches(&at, staged, rank);
    launch->total_ns = drawn.total_ns;
    launch->a_ns = drawn.a_ns;
    launch->b_ns = drawn.b_ns;
    r->spent_ns += (uint64_t)drawn.total_ns;
    return true;
}

// ---------------------------------------------------------------- a tuning

typedef struct watched {
    const replay *r;
    replay_outcome *outcome;
} watched;

// Adds a plan that is better than those before.
static void note_gain(const watched *w, const duet_plan *plan)
{
    replay_outcome *o = w->outcome;
    const replay_gain at = {(double)w->r->spent_ns * 1e-9, replay_median_ns(w->r, plan)};
    bool better = o->n_gains == 0 || at.median_ns < o->gains[o->n_gains - 1].median_ns;
    if (better && !isnan(at.median_ns) && o->n_gains < REPLAY_GAINS)
        o->gains[o->n_gains++] = at;
}

static bool watch(void *context, const duet_tune_progress *progress)
{
    const watched *w = context;
    if (strcmp(progress->stage, "share") == 0 || strcmp(progress->stage, "kernels and share") == 0)
        w->outcome->search_launches = progress->launches;
    note_gain(w, progress->plan);
    return true;
}

static bool give_spaces(void *context, const duet_plan *plan, int device, kernel_spaces *to,
                        duet_error *err)
{
    const recorded_space *s = &((const replay *)context)->spaces[device];
    bool ok = true;
    (void)plan;
    for (uint32_t i = 0; ok && i < s->n; ++i)
        ok = kernel_spaces_add(to, &s->kernels[i], err);
    return ok;
}

static bool check_fits(const replay *r, const duet_tune_def *def, script *own, duet_error *err)
{
    const strategy *s = strategy_of(def->strategy, own);
    if (!s)
        return strategy_check(def->strategy, err);
    bool joint = s->choice != STRATEGY_SHARE;
    return joint == r->surface->joint ||
           bad_argument(err, "strategy '%s' chooses %s; expected one for %s", s->name,
                        joint ? "kernels and share" : "a share alone",
                        joint ? "a share alone" : "kernels and share");
}

static bool tune(replay *r, const duet_tune_def *def, script *own, replay_outcome *outcome,
                 duet_tune_outcome *found, duet_error *err)
{
    // The surface is of one, whatever its name is, or of the configs of one.
    const char *variants[] = {r->surface->joint ? r->spaces[1].base : "auto"};
    duet_tune_def tuned = *def;
    tuned.variants = variants;
    tuned.n_variants = 1;
    tuned.modes = r->modes;
    tuned.n_modes = r->n_modes;
    watched w = {r, outcome};
    tuned.watch = watch;
    tuned.watch_context = &w;
    tune_problem problem = {
        .def = &tuned,
        .machine = {.context = r, .launch = launch_recorded},
        .script = own,
        .least_share = tune_least_share(r->surface->n),
    };
    if (r->surface->joint) {
        tuned.search = "kernels";
        problem.machine.read_kernels = give_spaces;
        plan_set_variants(&problem.plan, variants[0]);
    }
    trial_log log = {0};
    duet_error why = {0};
    bool ok = tune_run(&problem, &log, found, &why);
    trial_log_free(&log);
    if (why.status == DUET_STATUS_INTERRUPTED)
        return error_set(err, why.status, "stopped");
    return ok || error_copy(err, &why);
}

bool replay_run(replay *r, const duet_tune_def *def, script *own, replay_outcome *outcome,
                duet_error *err)
{
    duet_tune_outcome found;
    *outcome = (replay_outcome){0};
    r->random = rng_seed(def->seed);
    r->spent_ns = 0;
    if (!check_fits(r, def, own, err) || !tune(r, def, own, outcome, &found, err))
        return false;
    outcome->plan = found.plan;
    if (!r->surface->joint) {
        plan_set_variant(&outcome->plan, 0, r->surface->variant_a);
        plan_set_variant(&outcome->plan, 1, r->surface->variant_b);
    }
    memcpy(outcome->verdict, found.verdict, sizeof outcome->verdict);
    outcome->median_ns = replay_median_ns(r, &found.plan);
    outcome->loss = outcome->median_ns / r->best->median_ns - 1;
    outcome->launches = found.launches;
    outcome->seconds = (double)r->spent_ns * 1e-9;
    return true;
}
