// SPDX-License-Identifier: MIT
#include "tuner/online.h"

#include "tuner/stats.h"
#include "tuner/strategy.h"

#include <math.h>

// ---------------------------------------------------------------- drift

// A CUSUM of the log ratio in units of its own deviation, with half a unit of
// slack: at a limit of twelve a steady machine raises a false alarm once in
// about a million steps, and a shift of two units is seen within ten.
#define SMOOTHING 0.05
#define LEAST_DEVIATION 0.05 // a shift of less is not worth tuning for
#define SLACK 0.5
#define LIMIT 12.0
#define MOST_A_STEP 4.0 // so that a hiccup of one step does not raise it

bool drift_update(drift *d, double measured_ns, double expected_ns)
{
    if (!(measured_ns > 0 && expected_ns > 0))
        return false;
    if (d->n++ == 0)
        d->variance = LEAST_DEVIATION * LEAST_DEVIATION;
    double deviation = fmax(LEAST_DEVIATION, sqrt(d->variance));
    double most = MOST_A_STEP * deviation;
    double x = fmin(most, fmax(-most, log(measured_ns / expected_ns)));
    double off = x - d->mean;
    d->mean += SMOOTHING * off;
    d->variance = (1 - SMOOTHING) * (d->variance + SMOOTHING * off * off);
    d->up = fmax(0, d->up + x / deviation - SLACK);
    d->down = fmax(0, d->down - x / deviation - SLACK);
    return d->up > LIMIT || d->down > LIMIT;
}

// ---------------------------------------------------------------- settling

enum { SOUNDINGS = 3 }; // rounds that say what to expect of a rival

// Rivals are looked for after so many frames, and if none was better after twice as many.
enum { LEAST_REST = 32, MOST_REST = 1024 };

static const double WORTH = 0.97; // a race is worth it for a frame that is so much shorter

online online_begin(const listed_plan *plan, double most_extra)
{
    return (online){.plan = *plan, .most_extra = most_extra};
}

void online_end(online *o)
{
    search_end(&o->search);
}

static double balance_of(const search_sample *frame)
{
    return frame->b_ns ? (double)frame->a_ns / (double)frame->b_ns : 0;
}

// The median time of the frames that were seen of the kept plan (0) or the rival (1).
static search_sample median_of(const online *o, int which)
{
    return search_samples_median(o->seen[which].frames, o->seen[which].n);
}

static void see(online *o, int which, const search_sample *frame)
{
    online_seen *seen = &o->seen[which];
    if (seen->n < ONLINE_SETTLE)
        seen->frames[seen->n++] = *frame;
}

static void begin_seeing(online *o, online_state state)
{
    o->seen[0].n = o->seen[1].n = 0;
    o->state = state;
}

static void begin_settling(online *o)
{
    begin_seeing(o, ONLINE_SETTLING);
    o->rest = o->rested = 0;
}

static void settle(online *o, const search_sample *frame)
{
    static const bool all[2] = {true, true};
    see(o, 0, frame);
    if (o->seen[0].n < ONLINE_SETTLE)
        return;
    search_sample median = median_of(o, 0);
    double balances[ONLINE_SETTLE];
    for (uint32_t i = 0; i < ONLINE_SETTLE; ++i)
        balances[i] = balance_of(&o->seen[0].frames[i]);
    o->total_ns = (double)median.total_ns;
    o->balance = stats_median(balances, ONLINE_SETTLE);
    o->drifts[0] = o->drifts[1] = (drift){0};
    o->state = ONLINE_WATCHING;
    plan_times_follow(&o->times, &median, &o->plan, all);
}

// ---------------------------------------------------------------- rivals

static void begin_race(online *o, const listed_plan *rival, uint32_t rounds)
{
    race_options options = race_default_options();
    options.most_rounds = rounds ? rounds : options.most_rounds;
    o->rival = *rival;
    o->race = race_begin(2, &options);
    o->last = 0;
    begin_seeing(o, ONLINE_RACING);
}

// Whether no frame of a race is expected to take longer than is allowed: the rival's, nor the first
// ones after a change of kernels.
static bool is_allowed(const online *o, const listed_plan *rival)
{
    double longest = fmax(plan_times_expect(&o->times, rival), o->total_ns);
    return longest + plan_times_switch(&o->times, &o->plan, rival) <=
           (1 + o->most_extra) * o->total_ns;
}

// The rival that is expected to be the fastest, if it is worth a race.
static bool find_faster(const online *o, listed_plan *fastest)
{
    listed_plan rival;
    double least = WORTH * o->total_ns;
    bool found = false;
    for (uint32_t i = 0; plan_times_rival(&o->times, i, &rival); ++i) {
        double expected = plan_times_expect(&o->times, &rival);
        if (expected >= least || plan_is_same(&rival, &o->plan) || !is_allowed(o, &rival))
            continue;
        least = expected;
        *fastest = rival;
        found = true;
    }
    return found;
}

// How to sound a rival. The time of a device that has been idle is not known for certain: the
// device gets as little work as can be measured, or as makes the busy device quick enough.
static listed_plan sounding_of(const online *o, const listed_plan *rival)
{
    double most_ns = (1 + o->most_extra) * o->total_ns;
    int busy = o->plan.share == 0 ? 1 : 0;
    listed_plan plan = *rival;
    if (plan_is_shared(&o->plan) || rival->share == o->plan.share)
        return plan;
    plan.variant[busy] = o->plan.variant[busy];
    most_ns -= plan_times_switch(&o->times, &o->plan, &plan);
    uint32_t part = plan_times_largest_part(&o->times, &plan, busy, most_ns);
    plan.share = busy == 0 ? part : SEARCH_ONE - part;
    return plan;
}

static bool begin_sounding(online *o, const listed_plan *rival)
{
    listed_plan sounding = sounding_of(o, rival);
    if (plan_is_same(rival, &o->plan) || !is_allowed(o, &sounding))
        return false;
    begin_race(o, &sounding, SOUNDINGS);
    return true;
}

// The next in turn that may be tried.
static void sound_next(online *o)
{
    listed_plan rival;
    uint32_t n = 0;
    while (plan_times_rival(&o->times, n, &rival))
        ++n;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t at = (o->turn + i) % n;
        plan_times_rival(&o->times, at, &rival);
        if (!begin_sounding(o, &rival))
            continue;
        o->turn = at + 1;
        return;
    }
}

// Observations of a device that is idle, and stays so, count less and less.
static void expect_recovery(online *o)
{
    bool is_seen = o->state == ONLINE_RACING && plan_is_shared(&o->rival);
    if (!plan_is_shared(&o->plan) && !is_seen)
        plan_times_recover(&o->times, o->plan.share == 0 ? 0 : 1);
}

static void look_for_rivals(online *o)
{
    listed_plan rival;
    o->rested = 0;
    o->rest = o->rest ? 2 * o->rest : LEAST_REST;
    o->rest = o->rest < MOST_REST ? o->rest : MOST_REST;
    bool found = find_faster(o, &rival);
    if (found && plan_is_shared(&o->plan))
        begin_race(o, &rival, 0);
    else if (!found || !begin_sounding(o, &rival))
        sound_next(o);
    expect_recovery(o);
}

// By how much more a device takes than the kept plan's frames of the race let expect; 1 for one
// that it leaves idle.
static double disturbance(const online *o, int device)
{
    search_sample kept = median_of(o, 0);
    uint64_t ns = device == 0 ? kept.a_ns : kept.b_ns;
    double expected = plan_times_expect_part(&o->times, &o->plan, device);
    return ns > 0 && expected > 0 && isfinite(expected) ? (double)ns / expected : 1;
}

// A device that the kept plan leaves idle is known only by the rival.
static void learn_rival(online *o)
{
    if (race_rounds(&o->race, 0, 1) == 0)
        return;
    search_sample rival = median_of(o, 1);
    const bool all[2] = {o->plan.share == 0, o->plan.share == SEARCH_ONE};
    rival.a_ns = (uint64_t)((double)rival.a_ns / disturbance(o, 0));
    rival.b_ns = (uint64_t)((double)rival.b_ns / disturbance(o, 1));
    plan_times_follow(&o->times, &rival, &o->rival, all);
}

static bool begin_moving(online *o, const search_sample *frame, duet_error *err)
{
    search_options options = search_default_options();
    options.launches = ONLINE_MOVES;
    options.start = o->plan.share;
    o->state = ONLINE_MOVING;
    ++o->tunings;
    search_end(&o->search);
    return search_begin(&o->search, "chunks", &options, err) && search_tell(&o->search, frame, err);
}

static bool take_rival(online *o, duet_error *err)
{
    search_sample frame = median_of(o, 1);
    o->plan = o->rival;
    if (plan_is_shared(&o->plan))
        return begin_moving(o, &frame, err);
    ++o->tunings;
    begin_settling(o);
    return true;
}

static bool is_sounding(const online *o)
{
    return o->race.options.most_rounds == SOUNDINGS;
}

static bool end_race(online *o, duet_error *err)
{
    bool ran = race_rounds(&o->race, 0, 1) > 0;
    learn_rival(o);
    o->state = ONLINE_WATCHING;
    if (ran && race_compare(&o->race, 1, 0).verdict == RACE_FASTER)
        return take_rival(o, err);
    listed_plan rival;
    if (is_sounding(o) && find_faster(o, &rival))
        begin_race(o, &rival, 0);
    return true;
}

static bool is_too_slow(const online *o)
{
    return race_rounds(&o->race, 0, 1) >= (is_sounding(o) ? 1 : SOUNDINGS) &&
           race_median(&o->race, 1) > (1 + o->most_extra) * race_median(&o->race, 0);
}

static bool run_race(online *o, const search_sample *frame, duet_error *err)
{
    uint32_t turn;
    race_next(&o->race, &turn);
    if (o->last != turn) {
        o->last = turn;
        return true;
    }
    race_add(&o->race, turn, (double)frame->total_ns);
    see(o, (int)turn, frame);
    return (!is_too_slow(o) && race_next(&o->race, &turn)) || end_race(o, err);
}

bool online_is_trial(const online *o)
{
    uint32_t turn = 0;
    if (o->state == ONLINE_RACING)
        race_next(&o->race, &turn);
    return o->state == ONLINE_RACING && turn == 1;
}

void online_refuse(online *o)
{
    plan_times_forget(&o->times, &o->rival);
    o->state = ONLINE_WATCHING;
}

// ---------------------------------------------------------------- watching

static bool watch(online *o, const search_sample *frame, duet_error *err)
{
    bool slower = drift_update(&o->drifts[0], (double)frame->total_ns, o->total_ns);
    bool tilted = drift_update(&o->drifts[1], balance_of(frame), o->balance);
    if ((slower || tilted) && plan_is_shared(&o->plan))
        return begin_moving(o, frame, err);
    if (slower || tilted)
        begin_settling(o);
    else if (++o->rested >= o->rest)
        look_for_rivals(o);
    return true;
}

static bool move(online *o, const search_sample *frame, duet_error *err)
{
    search_next next;
    if (!search_tell(&o->search, frame, err) || !search_ask(&o->search, &next, err))
        return false;
    if (next.done) {
        o->plan.share = search_pick(&o->search);
        begin_settling(o);
    }
    return true;
}

bool online_tell(online *o, const search_sample *frame, duet_error *err)
{
    switch (o->state) {
    case ONLINE_SETTLING:
        settle(o, frame);
        return true;
    case ONLINE_WATCHING:
        return watch(o, frame, err);
    case ONLINE_MOVING:
        return move(o, frame, err);
    case ONLINE_RACING:
        return run_race(o, frame, err);
    }
    return true;
}

// ---------------------------------------------------------------- the next frame

// A frame at another share, by how each device's part grows and shrinks.
static double expect_total(const search_sample *frame, uint32_t share)
{
    double a = (double)frame->a_ns * share / frame->share;
    double b = (double)frame->b_ns * (SEARCH_ONE - share) / (SEARCH_ONE - frame->share);
    return fmax(a, b);
}

static bool next_share(const online *o, uint32_t *share, duet_error *err)
{
    search_next next;
    if (!search_ask(&o->search, &next, err))
        return false;
    const search_sample *last = &o->search.samples[o->search.n - 1];
    double most = (1 + o->most_extra) * expect_total(last, last->share);
    while (next.at.share != last->share && expect_total(last, next.at.share) > most)
        next.at.share = (next.at.share + last->share) / 2;
    *share = next.at.share;
    return true;
}

bool online_plan(const online *o, listed_plan *plan, duet_error *err)
{
    *plan = online_is_trial(o) ? o->rival : o->plan;
    return o->state != ONLINE_MOVING || next_share(o, &plan->share, err);
}
