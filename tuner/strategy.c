// SPDX-License-Identifier: MIT
// The table of strategies, and those that are short. balance has a file of its
// own.
#include "tuner/strategy.h"

#include "gen/sandbox.h"
#include "tuner/duet_tune.h"
#include "tuner/stats.h"

#include <lauxlib.h>
#include <string.h>

// The pick of strategies that trust single samples.
static uint32_t pick_fastest(const search_history *h)
{
    const search_sample *fastest = &h->samples[0];
    for (uint32_t i = 1; i < h->n; ++i) {
        if (h->samples[i].total_ns < fastest->total_ns)
            fastest = &h->samples[i];
    }
    return fastest->share;
}

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

static ends play(const search_history *h)
{
    ends e = {.up = h->samples[0], .down = h->samples[1]};
    for (uint32_t i = 2; i < h->n && !e.stopped; ++i)
        move_end(&e, &h->samples[i]);
    return e;
}

static bool fig12_ask(const search_history *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.share = h->n == 0 ? SEARCH_ONE : 0};
    if (h->n < 2)
        return true;
    ends e = play(h);
    next->done = e.stopped;
    next->share = (e.up.share + e.down.share) / 2;
    return true;
}

static void fig12_bracket(const search_history *h, uint32_t *low, uint32_t *high)
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
    .pick = pick_fastest,
    .bracket = fig12_bracket,
};

// ---------------------------------------------------------------- grid

// Every share of an even grid, in rounds: expensive, and right. Other strategies
// are judged by it.
//
// Rounds are interleaved, so that a slow minute falls on all shares alike.

static uint32_t share_of(const search_history *h, uint32_t point)
{
    return (uint32_t)((uint64_t)SEARCH_ONE * point / h->options.points);
}

static bool grid_ask(const search_history *h, search_next *next, duet_error *err)
{
    (void)err;
    uint32_t points = h->options.points + 1;
    next->done = h->n >= points * h->options.rounds;
    next->share = share_of(h, h->n % points);
    return true;
}

static double median_at(const search_history *h, uint32_t share)
{
    double totals[STATS_MOST];
    uint32_t n = 0;
    for (uint32_t i = 0; i < h->n && n < STATS_MOST; ++i) {
        if (h->samples[i].share == share)
            totals[n++] = (double)h->samples[i].total_ns;
    }
    return n ? stats_median(totals, n) : 0;
}

static uint32_t grid_pick(const search_history *h)
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

static uint32_t next_share(const search_history *h)
{
    double a = 0, b = 0;
    for (uint32_t i = 1; i < h->n; ++i) {
        follow(&a, h->samples[i].share, h->samples[i].a_ns);
        follow(&b, SEARCH_ONE - h->samples[i].share, h->samples[i].b_ns);
    }
    if (!(a > 0 && b > 0))
        return search_history_first_share(h);
    uint32_t wanted = (uint32_t)(SEARCH_ONE * (a / (a + b)) + 0.5);
    return limit_move(wanted, h->samples[h->n - 1].share, h->options.quantum);
}

static bool chunks_ask(const search_history *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.share = h->n == 0 ? 0 : next_share(h)};
    return true;
}

static uint32_t chunks_pick(const search_history *h)
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

// ---------------------------------------------------------------- lua

// The script's function stays at the bottom of its stack, and above it whether it chooses kernels
// too.
enum { FUNCTION = 1, IS_JOINT = 2 };

// the script's result -> the function in it, whether it is the field `joint`
static int find_function(lua_State *L)
{
    bool is_table = lua_istable(L, 1);
    bool joint = is_table && lua_getfield(L, 1, "joint") != LUA_TNIL;
    if (is_table && !joint)
        lua_getfield(L, 1, "strategy");
    lua_pushboolean(L, joint);
    return 2;
}

script *strategy_lua_open(const char *name, const char *chars, duet_error *err)
{
    script *s = sandbox_open(NULL, err);
    if (!s)
        return NULL;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, find_function);
    bool ok = script_run(s, name, chars, strlen(chars), 1, err) && script_call(s, 1, 2, err);
    if (ok && !lua_isfunction(L, FUNCTION))
        ok = error_set(err, DUET_STATUS_BAD_INPUT,
                       "%s: the strategy is a %s; expected a function of the history", name,
                       luaL_typename(L, FUNCTION));
    if (!ok) {
        script_close(s);
        return NULL;
    }
    return s;
}

bool strategy_lua_is_joint(script *s)
{
    return lua_toboolean(script_lua(s), IS_JOINT);
}

bool strategy_lua_call(script *s, int (*call)(lua_State *L), const void *history, void *next,
                       duet_error *err)
{
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, call);
    lua_pushvalue(L, FUNCTION);
    lua_pushlightuserdata(L, (void *)history);
    lua_pushlightuserdata(L, next);
    return script_call(s, 3, 0, err);
}

static void set_number(lua_State *L, const char *name, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

static void push_history(lua_State *L, const search_history *h)
{
    lua_createtable(L, (int)h->n, 0);
    for (uint32_t i = 0; i < h->n; ++i) {
        const search_sample *at = &h->samples[i];
        lua_createtable(L, 0, 4);
        set_number(L, "share", at->share / (double)SEARCH_ONE);
        set_number(L, "total", (double)at->total_ns * 1e-6);
        set_number(L, "a", (double)at->a_ns * 1e-6);
        set_number(L, "b", (double)at->b_ns * 1e-6);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

// function, history, next ->
static int call_function(lua_State *L)
{
    const search_history *h = lua_touserdata(L, 2);
    search_next *next = lua_touserdata(L, 3);
    lua_pushvalue(L, 1);
    push_history(L, h);
    lua_call(L, 1, 1);
    next->done = lua_isnil(L, -1);
    if (next->done)
        return 0;
    double share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        return luaL_error(L, "the strategy gave %s; expected a share of 0 to 1, or nil",
                          script_tostring(L, -1, NULL));
    next->share = (uint32_t)(share * SEARCH_ONE + 0.5);
    return 0;
}

static bool lua_ask(const search_history *h, search_next *next, duet_error *err)
{
    if (!h->script)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "strategy 'lua': there is no script; expected a function in tune.lua");
    return strategy_lua_call(h->script, call_function, h, next, err);
}

const strategy strategy_lua = {
    .name = "lua",
    .about = "a function of a script: history in, next share or nil out",
    .launches = 64,
    .ask = lua_ask,
    .pick = pick_fastest,
};

// ---------------------------------------------------------------- the table

const strategy *const strategies[] = {
    &strategy_balance, &strategy_fig12, &strategy_grid, &strategy_chunks, &strategy_lua, NULL,
};

const strategy *strategy_at(uint32_t i)
{
    return i < sizeof strategies / sizeof strategies[0] ? strategies[i] : NULL;
}

const strategy *strategy_find(const char *name)
{
    for (uint32_t i = 0; strategies[i]; ++i) {
        if (strcmp(strategies[i]->name, name) == 0)
            return strategies[i];
    }
    return NULL;
}

const char *duet_strategy_get_name(uint32_t i)
{
    const strategy *s = strategy_at(i);
    return s ? s->name : NULL;
}

const char *duet_strategy_get_summary(uint32_t i)
{
    const strategy *s = strategy_at(i);
    return s ? s->about : NULL;
}
