// SPDX-License-Identifier: MIT
// Golden section search on the total time (Kiefer 1953).
//
// Needs no device times, and is the best there is for a function with one
// minimum and no noise. Share 0 is measured first, since it is another path.
#include "tuner/strategy.h"

// The interval and its two inner points; a point without a time is still to
// be measured.
typedef struct section {
    uint32_t low;
    uint32_t high;
    search_sample left;
    search_sample right;
} section;

static uint32_t golden_step(uint32_t low, uint32_t high)
{
    return (uint32_t)((high - low) * 0.3819660112501051 + 0.5);
}

static void place_left(section *g)
{
    g->left = (search_sample){.share = g->low + golden_step(g->low, g->high)};
}

static void place_right(section *g)
{
    g->right = (search_sample){.share = g->high - golden_step(g->low, g->high)};
}

// Drops the part beyond the worse inner point; the better one stays inner.
static void shrink(section *g)
{
    if (g->left.total_ns <= g->right.total_ns) {
        g->high = g->right.share;
        g->right = g->left;
        place_left(g);
    } else {
        g->low = g->left.share;
        g->left = g->right;
        place_right(g);
    }
}

static section play(const search *s)
{
    section g = {.low = 0, .high = SEARCH_ONE};
    place_left(&g);
    place_right(&g);
    for (uint32_t i = 1; i < s->n; ++i) {
        if (g.left.total_ns == 0)
            g.left = s->samples[i];
        else
            g.right = s->samples[i];
        if (g.left.total_ns && g.right.total_ns)
            shrink(&g);
    }
    return g;
}

static bool ask(const search *s, search_next *next, duet_error *err)
{
    (void)err;
    section g = play(s);
    next->done = s->n > 0 && g.high - g.low <= 2 * s->options.quantum;
    next->share = s->n == 0 ? 0 : g.left.total_ns == 0 ? g.left.share : g.right.share;
    return true;
}

static void bracket(const search *s, uint32_t *low, uint32_t *high)
{
    section g = play(s);
    *low = g.low;
    *high = g.high;
}

const strategy strategy_golden = {
    .name = "golden",
    .about = "golden section search on the total time",
    .launches = 13,
    .ask = ask,
    .pick = strategy_pick_fastest,
    .bracket = bracket,
};
