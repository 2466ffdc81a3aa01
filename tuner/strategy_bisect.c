// SPDX-License-Identifier: MIT
// Bisection on which device finished last.
//
// A's time rises with the share and B's falls, so their difference has one
// root, and the root is where the longer of the two is least. Each launch
// halves the interval with certainty, as long as no time is disturbed. Share
// 0 is measured first, since it is another path: no second device at all.
#include "tuner/strategy.h"

static void bracket(const search *s, uint32_t *low, uint32_t *high)
{
    for (uint32_t i = 1; i < s->n; ++i) {
        const search_sample *at = &s->samples[i];
        if (at->a_ns <= at->b_ns)
            *low = at->share;
        if (at->a_ns >= at->b_ns)
            *high = at->share;
    }
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    (void)err;
    uint32_t low = 0, high = SEARCH_ONE;
    bracket(s, &low, &high);
    next->done = s->n > 0 && high - low <= s->options.quantum;
    next->share = s->n == 0 ? 0 : low + (high - low) / 2;
    return true;
}

const strategy strategy_bisect = {
    .name = "bisect",
    .about = "bisection on which device finished last",
    .launches = 13,
    .ask = ask,
    .pick = strategy_pick_fastest,
    .bracket = bracket,
};
