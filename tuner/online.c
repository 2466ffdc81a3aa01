// SPDX-License-Identifier: MIT
#include "tuner/online.h"

#include "tuner/stats.h"

#include <math.h>

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

// ---------------------------------------------------------------- states

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
    const search_sample *last = &o->search.samples[o->search.n - 1];
    double most = (1 + o->most_extra) * expect_total(last, last->share);
    while (next.share != last->share && expect_total(last, next.share) > most)
        next.share = (next.share + last->share) / 2;
    *share = next.share;
    return true;
}
