// SPDX-License-Identifier: MIT
// Follows the work instead of settling: every launch is a chunk of it.
//
// For irregular scenes a fixed share has a ceiling, since what an object costs
// moves with the scene. Here each chunk is shared by the speeds of the chunks
// just before it, the latest counting most. A first small share for A keeps a
// slow device from making the first chunk dear (Kaleem et al., PACT 2014), and
// a share at most doubles from one chunk to the next, so that one mistaken
// time does not throw it. It ends when the launches do; the pick is the share
// that it would use next, unless the last chunks took longer than the first,
// which B does alone.
#include "tuner/stats.h"
#include "tuner/strategy.h"

enum { MEMORY = 2 };

// Work per nanosecond, a running mean over about MEMORY + 1 chunks.
static void follow(double *speed, uint32_t work, uint64_t ns)
{
    if (work == 0 || ns == 0)
        return;
    double seen = (double)work / (double)ns;
    *speed = *speed > 0 ? *speed + (seen - *speed) / MEMORY : seen;
}

// Both devices keep a part, however small, or their speed would be forgotten.
static uint32_t limit_move(uint32_t wanted, uint32_t last, uint32_t quantum)
{
    uint32_t rest = SEARCH_ONE - last;
    uint32_t low = rest < SEARCH_ONE / 2 ? SEARCH_ONE - 2 * rest : quantum;
    uint32_t high = last < SEARCH_ONE / 2 ? 2 * last : SEARCH_ONE - quantum;
    low = low > quantum ? low : quantum;
    high = high < SEARCH_ONE - quantum ? high : SEARCH_ONE - quantum;
    return wanted < low ? low : wanted > high ? high : wanted;
}

static uint32_t next_share(const search *s)
{
    double a = 0, b = 0;
    for (uint32_t i = 1; i < s->n; ++i) {
        follow(&a, s->samples[i].share, s->samples[i].a_ns);
        follow(&b, SEARCH_ONE - s->samples[i].share, s->samples[i].b_ns);
    }
    if (!(a > 0 && b > 0))
        return search_first_share(s);
    uint32_t wanted = (uint32_t)(SEARCH_ONE * (a / (a + b)) + 0.5);
    return limit_move(wanted, s->samples[s->n - 1].share, s->options.quantum);
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.share = s->n == 0 ? 0 : next_share(s)};
    return true;
}

static uint32_t pick(const search *s)
{
    enum { LAST = 5 };
    double totals[LAST];
    uint32_t n = s->n > LAST ? LAST : s->n - 1;
    for (uint32_t i = 0; i < n; ++i)
        totals[i] = (double)s->samples[s->n - 1 - i].total_ns;
    bool worth_it = n > 0 && stats_median(totals, n) < (double)s->samples[0].total_ns;
    return worth_it ? next_share(s) : s->samples[0].share;
}

const strategy strategy_chunks = {
    .name = "chunks",
    .about = "shares each launch by the speeds of the last ones; never settles",
    .launches = 16,
    .ask = ask,
    .pick = pick,
};
