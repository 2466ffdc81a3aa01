// SPDX-License-Identifier: MIT
// Every share of an even grid, in rounds: dear, and right. The oracle that
// other strategies are judged by.
//
// Rounds are interleaved, so that a slow minute falls on all shares alike.
#include "tuner/stats.h"
#include "tuner/strategy.h"

static uint32_t share_of(const search *s, uint32_t point)
{
    return (uint32_t)((uint64_t)SEARCH_ONE * point / s->options.points);
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    (void)err;
    uint32_t points = s->options.points + 1;
    next->done = s->n >= points * s->options.rounds;
    next->share = share_of(s, s->n % points);
    return true;
}

static double median_at(const search *s, uint32_t share)
{
    double totals[STATS_MOST];
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n && n < STATS_MOST; ++i) {
        if (s->samples[i].share == share)
            totals[n++] = (double)s->samples[i].total_ns;
    }
    return n ? stats_median(totals, n) : 0;
}

static uint32_t pick(const search *s)
{
    uint32_t best = 0;
    double least = 0;
    for (uint32_t point = 0; point <= s->options.points; ++point) {
        double median = median_at(s, share_of(s, point));
        if (median > 0 && (least == 0 || median < least)) {
            least = median;
            best = share_of(s, point);
        }
    }
    return best;
}

const strategy strategy_grid = {
    .name = "grid",
    .about = "all shares of an even grid in interleaved rounds",
    .ask = ask,
    .pick = pick,
};
