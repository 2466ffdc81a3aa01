// SPDX-License-Identifier: MIT
// The paper's successive approximation (section 4.3, figure 12), as printed.
//
// It moves the slower end to the middle without knowing on which side of it
// the best share lies, and so loses that share for most speed ratios. It is
// here so that the paper's figures can be reproduced; docs/tuning.md says what
// it costs.
#include "tuner/strategy.h"

typedef struct ends {
    search_sample up;
    search_sample down;
    bool stopped;
} ends;

static const search_sample *slower_end(const ends *e)
{
    return e->up.total_ns >= e->down.total_ns ? &e->up : &e->down;
}

// One step of figure 12: a middle that beats the slower end replaces it.
static void move_end(ends *e, const search_sample *middle)
{
    const search_sample *slower = slower_end(e);
    if (middle->total_ns >= slower->total_ns)
        e->stopped = true;
    else if (slower == &e->up)
        e->up = *middle;
    else
        e->down = *middle;
}

static ends play(const search *s)
{
    ends e = {.up = s->samples[0], .down = s->samples[1]};
    for (uint32_t i = 2; i < s->n && !e.stopped; ++i)
        move_end(&e, &s->samples[i]);
    return e;
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.share = s->n == 0 ? SEARCH_ONE : 0};
    if (s->n < 2)
        return true;
    ends e = play(s);
    next->done = e.stopped;
    next->share = (e.up.share + e.down.share) / 2;
    return true;
}

static void bracket(const search *s, uint32_t *low, uint32_t *high)
{
    if (s->n < 2)
        return;
    ends e = play(s);
    *low = e.down.share;
    *high = e.up.share;
}

// Both ends and the first middle, then the paper's ten iterations.
const strategy strategy_fig12 = {
    .name = "fig12",
    .about = "the paper's successive approximation, as printed",
    .launches = 3 + 10,
    .ask = ask,
    .pick = strategy_pick_fastest,
    .bracket = bracket,
};
