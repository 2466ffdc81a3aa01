// SPDX-License-Identifier: MIT
#include "tuner/online.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/selection/profile_subject.h"
#include "tuner/measure.h"
#include "tuner/record.h"
#include "tuner/stats.h"

#include <math.h>
#include <stdlib.h>

enum { COOKIE = 0x0d0e7004 };

// ---------------------------------------------------------------- drift

// A CUSUM of the log ratio in units of its own deviation, with half a unit of
// slack: at a limit of twelve a steady machine raises a false alarm once in
// about a million steps, and a shift of two units is seen within ten.
#define SMOOTHING 0.05
#define LEAST_DEVIATION 0.05 // a shift of less is not worth tuning for
#define SLACK 0.5
#define LIMIT 12.0
#define MOST_A_STEP 4.0 // so that a hiccup of one step does not raise it

static double clamp(double x, double most)
{
    return fmin(most, fmax(-most, x));
}

bool drift_update(drift *d, double measured_ns, double expected_ns)
{
    if (!(measured_ns > 0 && expected_ns > 0))
        return false;
    if (d->n++ == 0)
        d->variance = LEAST_DEVIATION * LEAST_DEVIATION;
    double deviation = fmax(LEAST_DEVIATION, sqrt(d->variance));
    double x = clamp(log(measured_ns / expected_ns), MOST_A_STEP * deviation);
    double off = x - d->mean;
    d->mean += SMOOTHING * off;
    d->variance = (1 - SMOOTHING) * (d->variance + SMOOTHING * off * off);
    d->up = fmax(0, d->up + x / deviation - SLACK);
    d->down = fmax(0, d->down - x / deviation - SLACK);
    return d->up > LIMIT || d->down > LIMIT;
}

// ---------------------------------------------------------------- states

online online_begin(uint32_t share, double most_extra)
{
    return (online){.share = share, .most_extra = most_extra};
}

void online_end(online *o)
{
    search_end(&o->search);
}

// Of one device alone there is no balance to move.
static bool is_shared(const online *o)
{
    return o->share > 0 && o->share < SEARCH_ONE;
}

static double balance_of(const search_sample *frame)
{
    return frame->b_ns ? (double)frame->a_ns / (double)frame->b_ns : 0;
}

static void settle(online *o, const search_sample *frame)
{
    o->seen[o->n_seen++] = *frame;
    if (o->n_seen < ONLINE_SETTLE)
        return;
    double totals[ONLINE_SETTLE], balances[ONLINE_SETTLE];
    for (uint32_t i = 0; i < ONLINE_SETTLE; ++i) {
        totals[i] = (double)o->seen[i].total_ns;
        balances[i] = balance_of(&o->seen[i]);
    }
    o->total_ns = stats_median(totals, ONLINE_SETTLE);
    o->balance = stats_median(balances, ONLINE_SETTLE);
    o->drifts[0] = o->drifts[1] = (drift){0};
    o->n_seen = 0;
    o->state = ONLINE_WATCHING;
}

static bool begin_moving(online *o, const search_sample *frame, duet_error *err)
{
    search_options options = search_default_options();
    options.launches = ONLINE_MOVES;
    options.has_start = true;
    options.start = o->share;
    o->state = ONLINE_MOVING;
    ++o->tunings;
    search_end(&o->search);
    return search_begin(&o->search, "chunks", &options, err) && search_tell(&o->search, frame, err);
}

static bool watch(online *o, const search_sample *frame, duet_error *err)
{
    bool slower = drift_update(&o->drifts[0], (double)frame->total_ns, o->total_ns);
    bool tilted = drift_update(&o->drifts[1], balance_of(frame), o->balance);
    if (!slower && !tilted)
        return true;
    if (is_shared(o))
        return begin_moving(o, frame, err);
    o->state = ONLINE_SETTLING;
    return true;
}

static bool move(online *o, const search_sample *frame, duet_error *err)
{
    search_next next;
    if (!search_tell(&o->search, frame, err) || !search_ask(&o->search, &next, err))
        return false;
    if (next.done) {
        o->share = search_pick(&o->search);
        o->state = ONLINE_SETTLING;
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
    }
    return true;
}

// ---------------------------------------------------------------- the share

// A frame at another share, by how each device's part grows and shrinks.
static double expect_total(const search_sample *frame, uint32_t share)
{
    double a = (double)frame->a_ns * share / frame->share;
    double b = (double)frame->b_ns * (SEARCH_ONE - share) / (SEARCH_ONE - frame->share);
    return fmax(a, b);
}

bool online_share(const online *o, uint32_t *share, duet_error *err)
{
    *share = o->share;
    if (o->state != ONLINE_MOVING)
        return true;
    search_next next;
    if (!search_ask(&o->search, &next, err))
        return false;
    const search_sample *last = &o->search.history.samples[o->search.history.n - 1];
    double most = (1 + o->most_extra) * expect_total(last, last->share);
    while (next.share != last->share && expect_total(last, next.share) > most)
        next.share = (next.share + last->share) / 2;
    *share = next.share;
    return true;
}

// ---------------------------------------------------------------- on a world

struct duet_online {
    duet_online_def def;
    online online;
};

duet_online_def duet_default_online_def(void)
{
    return (duet_online_def){.most_extra = 0.1, .cookie = COOKIE};
}

duet_online *duet_online_create(const duet_online_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!def || def->cookie != COOKIE || !def->world)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "the def has no world or does not come from duet_default_online_def");
    if (!world_is_idle(def->world, __func__, err))
        return NULL;
    if (!(def->most_extra >= 0) || !isfinite(def->most_extra))
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "most_extra is %g; expected a part, as 0.1", def->most_extra);
    duet_online *o = calloc(1, sizeof *o);
    if (!o)
        return error_null(err, DUET_STATUS_NO_MEMORY, "no memory to tune on line");
    o->def = *def;
    world_hold(def->world);
    o->online = online_begin(duet_world_get_plan(def->world)->share, def->most_extra);
    return o;
}

bool duet_online_step(duet_online *o, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(o, __func__, "online", err) || !error_given(result, __func__, "result", err) ||
        !world_is_idle(o->def.world, __func__, err))
        return false;
    duet_plan plan = *duet_world_get_plan(o->def.world);
    if (!online_share(&o->online, &plan.share, err) ||
        !duet_world_set_plan(o->def.world, &plan, err) ||
        !duet_world_step(o->def.world, result, err))
        return false;
    search_sample frame = measure_sample(result, &plan);
    return online_tell(&o->online, &frame, err);
}

uint32_t duet_online_get_tunings(const duet_online *o)
{
    return o ? o->online.tunings : 0;
}

static bool keep(const duet_online *o, duet_error *err)
{
    profile_subject known;
    record r;
    if (!world_is_idle(o->def.world, "duet_online_destroy", err))
        return false;
    duet_plan plan = *duet_world_get_plan(o->def.world);
    plan.share = o->online.share;
    if (!profile_subject_read(o->def.world, &known, err))
        return false;
    profile_subject_settle(&known, duet_world_get_level(o->def.world));
    profile_request request = profile_subject_request(&known);
    if (!record_open(&r, o->def.store, err))
        return false;
    bool ok = record_aim(&r, &request, err) && record_online(&r, &plan, o->online.total_ns, err);
    record_close(&r);
    return ok;
}

bool duet_online_destroy(duet_online *o, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!o)
        return true;
    bool settled = o->online.tunings > 0 && o->online.state == ONLINE_WATCHING;
    bool ok = !o->def.keep || !settled || keep(o, err);
    online_end(&o->online);
    duet_world_destroy(o->def.world);
    free(o);
    return ok;
}
