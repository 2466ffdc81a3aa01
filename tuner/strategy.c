// SPDX-License-Identifier: MIT
// The table of strategies, and the short ones that choose a share alone.
#include "tuner/strategy.h"

#include "base/text.h"
#include "tuner/duet_tune.h"
#include "tuner/stats.h"

#include <string.h>

// ---------------------------------------------------------------- fig12

// The paper's successive approximation (section 4.3, figure 12), as printed.
//
// It moves the slower end to the middle without knowing on which side of it
// the best share lies, and so loses that share for most speed ratios. It is
// here so that the paper's figures can be reproduced; docs/tuning.md says what
// it costs.

typedef struct ends {
    search_sample up;
    search_sample down;
    bool stopped;
} ends;

// One step of figure 12: a middle that beats the slower end replaces it.
static void move_end(ends *e, const search_sample *middle)
{
    const search_sample *slower = e->up.total_ns >= e->down.total_ns ? &e->up : &e->down;
    if (middle->total_ns >= slower->total_ns)
        e->stopped = true;
    else if (slower == &e->up)
        e->up = *middle;
    else
        e->down = *middle;
}

static ends play(const search *h)
{
    ends e = {.up = h->samples[0], .down = h->samples[1]};
    for (uint32_t i = 2; i < h->n && !e.stopped; ++i)
        move_end(&e, &h->samples[i]);
    return e;
}

static bool fig12_ask(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.at.share = h->n == 0 ? SEARCH_ONE : 0};
    if (h->n < 2)
        return true;
    ends e = play(h);
    next->done = e.stopped;
    next->at.share = (e.up.share + e.down.share) / 2;
    return true;
}

static void fig12_bracket(const search *h, uint32_t *low, uint32_t *high)
{
    if (h->n < 2)
        return;
    ends e = play(h);
    *low = e.down.share;
    *high = e.up.share;
}

// Both ends and the first middle, then the paper's ten iterations.
static const strategy strategy_fig12 = {
    .name = "fig12",
    .about = "the paper's successive approximation, as printed",
    .launches = 3 + 10,
    .ask = fig12_ask,
    .pick = search_fastest,
    .bracket = fig12_bracket,
};

// ---------------------------------------------------------------- grid

// Every share of an even grid, in rounds: expensive, and right. Other strategies
// are judged by it.
//
// Rounds are interleaved, so that a slow minute falls on all shares alike.

static uint32_t share_of(const search *h, uint32_t point)
{
    return (uint32_t)((uint64_t)SEARCH_ONE * point / h->options.points);
}

static bool grid_ask(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    uint32_t points = h->options.points + 1;
    next->done = h->n >= points * h->options.rounds;
    next->at.share = share_of(h, h->n % points);
    return true;
}

static double median_at(const search *h, uint32_t share)
{
    double totals[STATS_MOST];
    uint32_t n = 0;
    for (uint32_t i = 0; i < h->n && n < STATS_MOST; ++i) {
        if (h->samples[i].share == share)
            totals[n++] = (double)h->samples[i].total_ns;
    }
    return n ? stats_median(totals, n) : 0;
}

static uint32_t grid_pick(const search *h)
{
    uint32_t best = 0;
    double least = 0;
    for (uint32_t point = 0; point <= h->options.points; ++point) {
        double median = median_at(h, share_of(h, point));
        if (median > 0 && (least == 0 || median < least)) {
            least = median;
            best = share_of(h, point);
        }
    }
    return best;
}

static const strategy strategy_grid = {
    .name = "grid",
    .about = "all shares of an even grid in interleaved rounds",
    .ask = grid_ask,
    .pick = grid_pick,
};

// ---------------------------------------------------------------- chunks

// Follows the work instead of settling: every launch is a chunk of it.
//
// A fixed share has a ceiling in irregular scenes, since the cost of an object moves with the
// scene. Here each chunk is shared by the speeds of the chunks just before it, the latest counting
// most. A first small share for A keeps a slow device from making the first chunk expensive (Kaleem
// et al., PACT 2014), and a share at most doubles from one chunk to the next, so that one mistaken
// time does not mislead it. It ends when the launches do; the pick is the share that it would use
// next, unless the last chunks took longer than the first, which B does alone.

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

static uint32_t next_share(const search *h)
{
    double a = 0, b = 0;
    for (uint32_t i = 1; i < h->n; ++i) {
        follow(&a, h->samples[i].share, h->samples[i].a_ns);
        follow(&b, SEARCH_ONE - h->samples[i].share, h->samples[i].b_ns);
    }
    if (!(a > 0 && b > 0))
        return search_first_share(h);
    uint32_t wanted = (uint32_t)(SEARCH_ONE * (a / (a + b)) + 0.5);
    return limit_move(wanted, h->samples[h->n - 1].share, h->options.quantum);
}

static bool chunks_ask(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.at.share = h->n == 0 ? 0 : next_share(h)};
    return true;
}

static uint32_t chunks_pick(const search *h)
{
    enum { LAST = 5 };
    double totals[LAST];
    uint32_t n = h->n > LAST ? LAST : h->n - 1;
    for (uint32_t i = 0; i < n; ++i)
        totals[i] = (double)h->samples[h->n - 1 - i].total_ns;
    bool worth_it = n > 0 && stats_median(totals, n) < (double)h->samples[0].total_ns;
    return worth_it ? next_share(h) : h->samples[0].share;
}

static const strategy strategy_chunks = {
    .name = "chunks",
    .about = "shares each launch by the speeds of the last ones; never settles",
    .launches = 16,
    .ask = chunks_ask,
    .pick = chunks_pick,
};

// ---------------------------------------------------------------- the table

const strategy *const strategies[] = {
    &strategy_balance,   &strategy_fig12, &strategy_grid,
    &strategy_chunks,    &strategy_lua,   &strategy_random,
    &strategy_annealing, &strategy_brute, NULL,
};

const strategy *strategy_find(const char *name)
{
    const strategy *const *at = strategies;
    while (*at && strcmp((*at)->name, name) != 0)
        ++at;
    return *at;
}

const strategy *strategy_of(const char *name, script *own)
{
    bool joint = own && strcmp(name, strategy_lua.name) == 0 && strategy_lua_is_joint(own);
    return joint ? &strategy_lua_joint : strategy_find(name);
}

bool strategy_check(const char *name, duet_error *err)
{
    if (strategy_find(name))
        return true;
    text known = {0};
    bool joint = false;
    for (uint32_t i = 0; strategies[i]; ++i) {
        bool first = joint != (strategies[i]->choice != STRATEGY_SHARE);
        joint |= first;
        text_add(&known, "%s%s%s", i ? ", " : "",
                 first ? "and for kernels and share together " : "", strategies[i]->name);
    }
    bad_argument(err, "strategy '%s': there is none; there are %s", name, text_chars(&known));
    text_free(&known);
    return false;
}

bool search_begin(search *s, const char *name, const search_options *options, duet_error *err)
{
    *s = (search){.strategy = strategy_find(name),
                  .options = options ? *options : search_default_options()};
    if (!strategy_check(name, err))
        return false;
    s->options.quantum = s->options.quantum ? s->options.quantum : 1;
    return s->strategy->choice == STRATEGY_SHARE ||
           bad_argument(err, "strategy '%s' chooses kernels too; expected one for the share alone",
                        name);
}

static const strategy *share_strategy_at(uint32_t i)
{
    const uint32_t n = sizeof strategies / sizeof *strategies - 1;
    return i < n && strategies[i]->choice == STRATEGY_SHARE ? strategies[i] : NULL;
}

const char *duet_strategy_get_name(uint32_t i)
{
    const strategy *s = share_strategy_at(i);
    return s ? s->name : NULL;
}

const char *duet_strategy_get_summary(uint32_t i)
{
    const strategy *s = share_strategy_at(i);
    return s ? s->about : NULL;
}
