// SPDX-License-Identifier: MIT
// Shares are interpolated over 1/n: of two devices with straight lines for times, that is exact, as
// times over n are.
#include "profiles/neighbour.h"

#include "profiles/sql.h"

#include <math.h>
#include <string.h>

#define NEXT_SIZE 1.1   // a tenth
#define NEXT_REST 1.25  // a quarter
#define ALIKE_SKEW 2.0  // crowding by occupancy is a sample's: an octave, as in keys
#define MOST_GAP 8      // between sizes of which one shares and the other does not
#define LEAST_GAIN -0.9 // least gain of a store that says less, so that times stay finite

const char *neighbour_quantity_name(neighbour_quantity quantity)
{
    static const char *const names[] = {"objects", "objects a cell", "objects in the fullest cells",
                                        "ratio of sizes", "layers of cells"};
    return names[quantity];
}

void neighbour_describe(const profile_workload *w, double quantities[NEIGHBOUR_QUANTITIES])
{
    quantities[NEIGHBOUR_OBJECTS] = (double)w->n;
    quantities[NEIGHBOUR_OCCUPANCY] = w->occ_mean;
    quantities[NEIGHBOUR_CROWDING] = w->occ_p99;
    quantities[NEIGHBOUR_SIZES] = w->size_ratio;
    quantities[NEIGHBOUR_LAYERS] = w->cells[w->dims == 3 ? 2 : 1];
}

static double ratio_of(double a, double b)
{
    return a == b ? 1 : fmax(a, b) / fmin(a, b);
}

double neighbour_ratio(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES],
                       neighbour_quantity *worst)
{
    double most = 1;
    for (int q = 0; q < NEIGHBOUR_QUANTITIES; ++q) {
        double ratio = ratio_of(a[q], b[q]);
        if (worst && (q == 0 || ratio > most))
            *worst = (neighbour_quantity)q;
        most = fmax(most, ratio);
    }
    return most;
}

static double skew_of(const double quantities[NEIGHBOUR_QUANTITIES])
{
    double mean = quantities[NEIGHBOUR_OCCUPANCY];
    return mean > 0 ? quantities[NEIGHBOUR_CROWDING] / mean : 0;
}

bool neighbour_is_alike(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES])
{
    double grown = NEXT_REST * ratio_of(a[NEIGHBOUR_OBJECTS], b[NEIGHBOUR_OBJECTS]);
    return ratio_of(a[NEIGHBOUR_OCCUPANCY], b[NEIGHBOUR_OCCUPANCY]) <= grown &&
           ratio_of(a[NEIGHBOUR_LAYERS], b[NEIGHBOUR_LAYERS]) <= grown &&
           ratio_of(a[NEIGHBOUR_SIZES], b[NEIGHBOUR_SIZES]) <= ALIKE_SKEW &&
           ratio_of(skew_of(a), skew_of(b)) <= ALIKE_SKEW;
}

bool neighbour_is_next(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES])
{
    return ratio_of(a[NEIGHBOUR_OBJECTS], b[NEIGHBOUR_OBJECTS]) <= NEXT_SIZE &&
           neighbour_ratio(a, b, NULL) <= NEXT_REST;
}

// ---------------------------------------------------------------- plans and times

static bool shares(uint32_t share)
{
    return share > 0 && share < PROFILE_SHARE_ONE;
}

static double factor(double gain)
{
    return 1 + fmax(gain, LEAST_GAIN);
}

double neighbour_safe_ratio(const profile_found *found)
{
    double lead = shares(found->plan.share) ? factor(found->gain_low)
                  : found->plan.share == 0  ? 1 / factor(found->gain_high)
                                            : 1;
    return lead > 1 ? lead * lead : 1;
}

void neighbour_copy_plan(const profile_found *near, profile_found *found)
{
    *found = (profile_found){
        .plan = near->plan,
        .share_low = near->plan.share,
        .share_high = near->plan.share,
        .true_pairs = -1,
    };
}

static double single_ns(const profile_found *f)
{
    if (!shares(f->plan.share))
        return f->median_ns;
    return f->single_ns > 0 ? f->single_ns : f->median_ns * factor(f->gain);
}

static double shared_ns(const profile_found *f)
{
    return shares(f->plan.share) ? f->median_ns : f->median_ns / factor(f->gain);
}

static void set_gain(profile_found *found, double low, double gain, double high)
{
    const char *verdict = low > 0 ? "faster" : high < 0 ? "slower" : "same";
    found->gain_low = fmin(low, gain);
    found->gain = gain;
    found->gain_high = fmax(high, gain);
    sql_copy(found->verdict, sizeof found->verdict, verdict);
}

void neighbour_scale(const neighbour *near, const double at[NEIGHBOUR_QUANTITIES],
                     profile_found *found)
{
    const profile_found *f = &near->found;
    double grown = at[NEIGHBOUR_OBJECTS] / near->quantities[NEIGHBOUR_OBJECTS];
    double ratio = neighbour_ratio(near->quantities, at, NULL);
    neighbour_copy_plan(f, found);
    found->median_ns = f->median_ns * grown;
    found->single_ns = f->single_ns * grown;
    found->whole_ns = f->whole_ns * grown;
    found->whole_gain = f->whole_gain;
    found->whole_gain_low = factor(f->whole_gain_low) / ratio - 1;
    found->whole_gain_high = factor(f->whole_gain_high) * ratio - 1;
    found->best_share = f->best_share;
    sql_copy(found->best_mode, sizeof found->best_mode, f->best_mode);
    set_gain(found, factor(f->gain_low) / ratio - 1, f->gain, factor(f->gain_high) * ratio - 1);
}

// ---------------------------------------------------------------- between two

// Two neighbours, and where between them the workload lies: 0 is below, 1 above.
typedef struct span {
    const profile_found *ends[2];
    double gap;         // by ratio
    double along;       // in objects
    double along_share; // in 1 / objects
    int near;           // the nearer end, by ratio
} span;

static span span_of(const neighbour *below, const neighbour *above, double n)
{
    double from = below->quantities[NEIGHBOUR_OBJECTS], to = above->quantities[NEIGHBOUR_OBJECTS];
    return (span){
        .ends = {&below->found, &above->found},
        .gap = to / from,
        .along = (n - from) / (to - from),
        .along_share = (1 / from - 1 / n) / (1 / from - 1 / to),
        .near = n / from > to / n,
    };
}

static double line(const span *s, double (*of)(const profile_found *))
{
    double from = of(s->ends[0]), to = of(s->ends[1]);
    return from + (to - from) * s->along;
}

static bool same_kernels(const profile_plan *a, const profile_plan *b)
{
    return strcmp(a->variant_a, b->variant_a) == 0 && strcmp(a->variant_b, b->variant_b) == 0;
}

// The shared plan of the nearer end that shares; its share moves towards the other end's best one
// if both are of one mode and the same kernels.
static void take_shared(const span *s, profile_found *found)
{
    int end = shares(s->ends[s->near]->plan.share) ? s->near : !s->near;
    const profile_found *a = s->ends[0], *b = s->ends[1];
    neighbour_copy_plan(s->ends[end], found);
    if (strcmp(a->best_mode, b->best_mode) != 0 || !same_kernels(&a->plan, &b->plan) ||
        !shares(a->best_share) || !shares(b->best_share))
        return;
    double from = a->best_share, to = b->best_share;
    found->plan.share = (uint32_t)lround(from + (to - from) * s->along_share);
    found->share_low = (uint32_t)fmin(from, to);
    found->share_high = (uint32_t)fmax(from, to);
}

static void take_single(const span *s, profile_found *found)
{
    int end = shares(s->ends[s->near]->plan.share) ? !s->near : s->near;
    neighbour_copy_plan(s->ends[end], found);
}

static double whole_ns(const profile_found *f)
{
    return f->whole_ns;
}

static void predict(const span *s, bool shared, profile_found *found)
{
    const profile_found *a = s->ends[0], *b = s->ends[1];
    double both = line(s, shared_ns), one = line(s, single_ns);
    found->median_ns = shared ? both : one;
    found->single_ns = one;
    found->best_share = shared ? found->plan.share : s->ends[s->near]->best_share;
    sql_copy(found->best_mode, sizeof found->best_mode,
             shared ? found->plan.mode : s->ends[s->near]->best_mode);
    set_gain(found, fmin(a->gain_low, b->gain_low), both > 0 ? one / both - 1 : 0,
             fmax(a->gain_high, b->gain_high));
    if (!(a->whole_ns > 0 && b->whole_ns > 0 && found->median_ns > 0))
        return;
    found->whole_ns = line(s, whole_ns);
    found->whole_gain = found->whole_ns / found->median_ns - 1;
    found->whole_gain_low = fmin(found->whole_gain, fmin(a->whole_gain_low, b->whole_gain_low));
    found->whole_gain_high = fmax(found->whole_gain, fmax(a->whole_gain_high, b->whole_gain_high));
}

// How the two ends divide the work. If one shares and the other does not, the predicted times
// decide, within a range in which a line is not far off. A alone at one end may be slower than B
// alone.
static bool choose(const span *s, bool *shared)
{
    uint32_t from = s->ends[0]->plan.share, to = s->ends[1]->plan.share;
    *shared = shares(from) && shares(to);
    if (*shared || from == to)
        return true;
    if (s->gap > MOST_GAP || (!shares(from) && !shares(to)))
        return false;
    *shared = line(s, shared_ns) < line(s, single_ns);
    return *shared || (shares(from) ? to : from) == 0;
}

bool neighbour_between(const neighbour *below, const neighbour *above,
                       const double at[NEIGHBOUR_QUANTITIES], profile_found *found)
{
    span s = span_of(below, above, at[NEIGHBOUR_OBJECTS]);
    bool shared;
    if (!choose(&s, &shared))
        return false;
    if (shared)
        take_shared(&s, found);
    else
        take_single(&s, found);
    predict(&s, shared, found);
    return true;
}
