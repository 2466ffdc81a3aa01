// SPDX-License-Identifier: MIT
// The default: balances two straight lines, one a device, inside a bracket.
//
// Share 0 is the baseline and a small share the first probe. From there each device's time is a
// line over its work, fitted so that disturbed launches count little, and the next share is where
// the lines cross, kept inside the bracket that the sign of A's time minus B's proves. When a share
// near the crossing took what the lines say, it is raced against the baselines and its neighbours,
// in turn, and shares that are clearly slower drop out. If the lines do not come true, the shares
// of a coarse grid are raced instead; if they cross far above B's time alone, only the single
// devices are left.
//
// The expensive end, where the slow device does everything, is only approached by
// shares that the line of that device says are cheap enough.
#include "tuner/stats.h"
#include "tuner/strategy.h"

#include <math.h>

enum {
    LEAST_REFINED = 4, // launches until the lines may say that sharing only costs
    MOST_REFINED = 7,  // launches until they must have come true
    MOST_RACED = 16,   // launches in all, if they did
    SURVEY = 8,        // intervals of the coarse grid, if they did not
    MOST_REPEATS = 64, // samples that are looked at
};

static const double NOISE = 0.05;     // assumed of one time, before any was seen twice
static const double OVERHEAD = 0.5;   // assumed at most of a device's part, of all the work
static const double NEAR = 0.4;       // log of a / b beyond which a sample says little of the root
static const double SURE = 3;         // deviations that decide a sign
static const double CLOSE = 0.005;    // a share this near to the best needs no nearer one
static const double NEIGHBOUR = 0.04; // a neighbour is expected to be slower by this
static const double LINE_SAMPLES = 2; // the lines count as so many samples at a share
static const double EQUAL = 0.002;    // repeats this near to each other show no noise
static const double VAIN = 1.5;       // a crossing this far above B alone ends the search
static const double WORTH_ALONE = 1.15; // A alone is measured if it may take so much of B alone

// A device's time for a part of the work, over B's time for all of it.
typedef struct line {
    double at_zero;
    double slope;
} line;

// Describes what the first n samples say.
typedef struct model {
    line lines[2];
    double noise;      // deviation of a time from its line, as a part of it
    uint32_t low;      // the root of A's time minus B's lies
    uint32_t high;     // between these, by proven signs
    uint32_t crossing; // the next share to try
} model;

static double part_of(uint32_t share, int device)
{
    return (device == 0 ? share : SEARCH_ONE - share) / (double)SEARCH_ONE;
}

static double unit_ns(const search *h)
{
    return fmax((double)h->samples[0].total_ns, 1);
}

static double time_of(const search *h, uint32_t i, int device)
{
    const search_sample *at = &h->samples[i];
    return (double)(device == 0 ? at->a_ns : at->b_ns) / unit_ns(h);
}

static double line_at(const line *l, double part)
{
    return l->at_zero + l->slope * part;
}

static double expected_total(const model *m, uint32_t share)
{
    return fmax(line_at(&m->lines[0], part_of(share, 0)), line_at(&m->lines[1], part_of(share, 1)));
}

static bool both_took_part(const search_sample *at)
{
    return at->a_ns > 0 && at->b_ns > 0;
}

// The lines need to be right where they cross: a sample that was far out of
// balance counts little, and one of a single device next to nothing.
static double nearness(const search_sample *at)
{
    if (!both_took_part(at))
        return 0.02;
    double out = log((double)at->a_ns / (double)at->b_ns) / NEAR;
    return 0.02 + 1 / (1 + out * out);
}

// ---------------------------------------------------------------- lines

// Weighted least squares with relative errors. The assumption that no work
// takes no time, give or take an overhead, counts as one sample: it is what
// makes a line of a single probe.
static line fit_weighted(const search *h, uint32_t n, int device, const double *weights)
{
    double w = 1 / (OVERHEAD * OVERHEAD), wx = 0, wxx = 0, wy = 0, wxy = 0;
    for (uint32_t i = 0; i < n; ++i) {
        double x = part_of(h->samples[i].share, device), y = time_of(h, i, device);
        w += weights[i];
        wx += weights[i] * x;
        wxx += weights[i] * x * x;
        wy += weights[i] * y;
        wxy += weights[i] * x * y;
    }
    if (!(wxx > 0))
        return (line){0};
    double through_zero = wxy / wxx;
    line l = {.slope = (w * wxy - wx * wy) / (w * wxx - wx * wx)};
    l.slope = fmax(l.slope, 0.1 * through_zero);
    l.at_zero = (wy - l.slope * wx) / w;
    return l.at_zero < 0 ? (line){.slope = through_zero} : l;
}

// Huber's weights, iterated: a disturbed launch pulls no harder than one that
// is 1.5 deviations off.
static line fit_line(const search *h, uint32_t n, int device)
{
    double weights[MOST_REPEATS];
    line l = {0};
    for (int pass = 0; pass < 6; ++pass) {
        for (uint32_t i = 0; i < n; ++i) {
            double time = time_of(h, i, device);
            double expected = line_at(&l, part_of(h->samples[i].share, device));
            double off = pass ? fabs(time / expected - 1) / NOISE : 0;
            weights[i] = time > 0 ? nearness(&h->samples[i]) / pow(NOISE * time, 2) : 0;
            weights[i] *= off > 1.5 ? 1.5 / off : 1;
        }
        l = fit_weighted(h, n, device, weights);
    }
    return l;
}

// From the residuals, with the assumed noise as one of them; a spike counts
// as 20 %, so that one does not hide everything else.
static double find_noise(const search *h, uint32_t n, const line lines[2])
{
    double sum = NOISE * NOISE, count = 1;
    for (uint32_t i = 0; i < n; ++i) {
        double near = nearness(&h->samples[i]);
        for (int device = 0; device < 2; ++device) {
            double time = time_of(h, i, device);
            if (time == 0)
                continue;
            double off = log(time / line_at(&lines[device], part_of(h->samples[i].share, device)));
            sum += near * fmin(off * off, 0.2 * 0.2);
            count += near;
        }
    }
    return sqrt(sum / count);
}

// ---------------------------------------------------------------- bracket

// The sign of A's time minus B's at a share, by all its samples; 0: not sure.
static int sign_at(const search *h, uint32_t n, uint32_t share, double noise)
{
    double differences[MOST_REPEATS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < n; ++i) {
        const search_sample *at = &h->samples[i];
        if (at->share == share && both_took_part(at))
            differences[count++] = log((double)at->a_ns / (double)at->b_ns);
    }
    return count ? stats_sign(differences, count, noise * sqrt(2), SURE) : 0;
}

static void find_bracket(const search *h, uint32_t n, model *m)
{
    m->low = 0;
    m->high = SEARCH_ONE;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t share = h->samples[i].share;
        int sign = sign_at(h, n, share, m->noise);
        if (sign < 0 && share > m->low)
            m->low = share;
        if (sign > 0 && share < m->high)
            m->high = share;
    }
}

// A multiple of the quantum that leaves both devices some work.
static uint32_t to_share(const search *h, double part)
{
    double quanta = floor(part * SEARCH_ONE / h->options.quantum + 0.5);
    uint32_t most = (SEARCH_ONE - 1) / h->options.quantum;
    return h->options.quantum * (uint32_t)fmin(fmax(quanta, 1), most);
}

// Returns the part at which A is expected to take no longer than the dearest launch allowed.
static double affordable(const search *h, const model *m, double part)
{
    const line *a = &m->lines[0];
    return fmin(part, fmax(0, (h->options.probe_cost - a->at_zero) / a->slope));
}

static uint32_t find_crossing(const search *h, const model *m)
{
    const line *a = &m->lines[0], *b = &m->lines[1];
    double part = (b->at_zero + b->slope - a->at_zero) / (a->slope + b->slope);
    double low = part_of(m->low, 0), high = part_of(m->high, 0);
    if (part < low || part > high)
        part = (low + high) / 2;
    return to_share(h, affordable(h, m, part));
}

static model look(const search *h, uint32_t n)
{
    model m;
    n = n < MOST_REPEATS ? n : MOST_REPEATS;
    for (int device = 0; device < 2; ++device)
        m.lines[device] = fit_line(h, n, device);
    m.noise = find_noise(h, n, m.lines);
    find_bracket(h, n, &m);
    m.crossing = find_crossing(h, &m);
    return m;
}

// ---------------------------------------------------------------- race

// The shares that enter the race: the first `refined` samples have led to them.
typedef struct field {
    uint32_t refined;
    bool surveyed; // the lines did not come true
    uint32_t rivals[SURVEY + 1];
    uint32_t n;
} field;

// A share that both had a part in, that the lines call as good as the
// crossing, and that took what they say.
static bool came_true(const search *h, uint32_t i, const model *m)
{
    const search_sample *at = &h->samples[i];
    if (!both_took_part(at))
        return false;
    double expected = expected_total(m, at->share);
    double off = fabs((double)at->total_ns / unit_ns(h) / expected - 1);
    return at->share == m->crossing ||
           (expected < (1 + CLOSE) * expected_total(m, m->crossing) && off < CLOSE + 2 * m->noise);
}

static void enter(field *f, uint32_t share)
{
    for (uint32_t i = 0; i < f->n; ++i) {
        if (f->rivals[i] == share)
            return;
    }
    f->rivals[f->n++] = share;
}

static void enter_alone(const model *m, field *f)
{
    enter(f, 0);
    if (line_at(&m->lines[0], 1) < WORTH_ALONE)
        enter(f, SEARCH_ONE);
}

static void enter_neighbours(const search *h, const model *m, uint32_t best, field *f)
{
    double part = part_of(best, 0), step = NEIGHBOUR * expected_total(m, best);
    enter(f, best);
    enter_alone(m, f);
    enter(f, to_share(h, part - step / m->lines[1].slope));
    enter(f, to_share(h, part + step / m->lines[0].slope));
}

static void enter_grid(const search *h, const model *m, field *f)
{
    f->surveyed = true;
    enter_alone(m, f);
    for (uint32_t k = 1; k < SURVEY; ++k) {
        double part = k / (double)SURVEY;
        if (affordable(h, m, part) == part)
            enter(f, to_share(h, part));
    }
}

// False while shares are still being refined; next is then the one to try.
static bool find_field(const search *h, field *f, uint32_t *next)
{
    model m = {0};
    *f = (field){0};
    for (uint32_t n = 2; n <= h->n; ++n) {
        m = look(h, n);
        f->refined = n;
        for (uint32_t i = n; i-- > 0;) {
            if (came_true(h, i, &m)) {
                enter_neighbours(h, &m, h->samples[i].share, f);
                return true;
            }
        }
        if (n >= LEAST_REFINED && expected_total(&m, m.crossing) > VAIN) {
            enter_alone(&m, f);
            return true;
        }
        if (n == MOST_REFINED) {
            enter_grid(h, &m, f);
            return true;
        }
    }
    *next = m.crossing;
    return false;
}

static uint32_t gather(const search *h, uint32_t from, uint32_t share, double *totals)
{
    uint32_t n = 0;
    for (uint32_t i = from; i < h->n && n < MOST_REPEATS; ++i) {
        if (h->samples[i].share == share)
            totals[n++] = (double)h->samples[i].total_ns / unit_ns(h);
    }
    return n;
}

typedef struct estimate {
    double total;
    uint32_t n; // samples behind it
} estimate;

// The median, drawn to the lines as if they were a few samples more: the least
// of several noisy medians is too good to be true. A device alone is another
// path, and after a survey the lines are known to be wrong.
static estimate estimate_total(const search *h, const model *m, uint32_t share, bool surveyed)
{
    double totals[MOST_REPEATS];
    estimate e = {.n = gather(h, 0, share, totals)};
    double median = e.n ? stats_median(totals, e.n) : 0;
    bool alone = share == 0 || share == SEARCH_ONE;
    double drawn = alone || surveyed ? 0 : LINE_SAMPLES;
    if (e.n + drawn > 0)
        e.total = (e.n * median + drawn * expected_total(m, share)) / (e.n + drawn);
    return e;
}

// All repeats agree: one time of each rival is all there is to know.
static bool is_quiet(const search *h)
{
    uint32_t repeats = 0;
    for (uint32_t i = 1; i < h->n; ++i) {
        const search_sample *first = search_at(h, h->samples[i].share);
        double off = (double)h->samples[i].total_ns / (double)first->total_ns - 1;
        if (fabs(off) > EQUAL)
            return false;
        repeats += first != &h->samples[i];
    }
    return repeats >= 2;
}

// Finds the rival to measure next: among the rivals that may still win, the one measured least in
// the race. None if only the leader is left.
static search_next race(const search *h, const field *f)
{
    model m = look(h, h->n);
    bool quiet = is_quiet(h);
    double noise = quiet ? EQUAL / 2 : m.noise;
    estimate seen[SURVEY + 1];
    uint32_t leader = f->n;
    for (uint32_t i = 0; i < f->n; ++i) {
        seen[i] = estimate_total(h, &m, f->rivals[i], f->surveyed);
        if (seen[i].n && (leader == f->n || seen[i].total < seen[leader].total))
            leader = i;
    }
    uint32_t alive = 0, fewest = UINT32_MAX;
    search_next next = {.done = true};
    for (uint32_t i = 0; i < f->n; ++i) {
        double totals[MOST_REPEATS];
        double width = 2 * noise * sqrt(1.0 / fmax(seen[i].n, 1) + 1.0 / seen[leader].n);
        if (i != leader && seen[i].total > seen[leader].total * (1 + width))
            continue;
        uint32_t raced = gather(h, f->refined, f->rivals[i], totals);
        ++alive;
        if (raced < fewest) {
            fewest = raced;
            next.at.share = f->rivals[i];
        }
    }
    next.done = h->n > f->refined && (alive <= 1 || (quiet && fewest > 0));
    return next;
}

// ---------------------------------------------------------------- strategy

static bool ask(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.at.share = h->n == 0 ? 0 : search_first_share(h)};
    field f;
    if (h->n < 2 || !find_field(h, &f, &next->at.share))
        return true;
    *next = race(h, &f);
    next->done = next->done || (!f.surveyed && h->n >= MOST_RACED);
    return true;
}

static uint32_t pick(const search *h)
{
    field f;
    uint32_t next;
    if (h->n < 2)
        return 0;
    find_field(h, &f, &next);
    model m = look(h, h->n);
    uint32_t best = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < h->n; ++i) {
        estimate e = estimate_total(h, &m, h->samples[i].share, f.surveyed);
        if (e.total < least) {
            least = e.total;
            best = h->samples[i].share;
        }
    }
    return best;
}

static void bracket(const search *h, uint32_t *low, uint32_t *high)
{
    if (h->n < 2)
        return;
    model m = look(h, h->n);
    *low = m.low;
    *high = m.high;
}

const strategy strategy_balance = {
    .name = "balance",
    .about = "balances a line for each device inside a bracket, then races the rivals",
    .evened = true,
    .launches = 2 * MOST_RACED,
    .ask = ask,
    .pick = pick,
    .bracket = bracket,
};
