// SPDX-License-Identifier: MIT
// Random commands, queries, saves and loads: the same bits with any plan, and the answers of
// a plain C twin. With --all they go to worlds of all kinds, and to many bodies.
#include "support/asker.h"
#include "support/commands.h"
#include "support/orders.h"

#include "runtime/opencl/device_pair.h"

static const char saved[] = "saved";
static const char past[] = "past";

enum { PLAYERS = 5 };

static int n_fuzzed_steps = 120, first_world = 0, n_worlds = 1;
static uint32_t n_bodies = 200;

// Worlds that kernels and buffers differ in.
typedef enum world_kind { USUAL, FLAT, DOUBLES, PLACED, FLIGHT, WORLD_KINDS } world_kind;

// One stream of commands goes to motions with several plans.
typedef struct play {
    world_kind kind;
    orders orders;
    mover *movers[PLAYERS];
    asker *askers[PLAYERS];
    uint32_t n_searched_some; // steps of the last player
    known_ids past;
    bool has_past;
} play;

// Each id once.
static void without_twins(order *o)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < o->n; ++i) {
        bool seen = false;
        for (uint32_t k = 0; k < n; ++k)
            seen |= o->ids[k] == o->ids[i];
        if (!seen)
            o->ids[n++] = o->ids[i];
    }
    o->n = n;
}

// Some are refused, such as a target for what has a mass: by all alike.
#define TARGET duet_motion *m
#define CALL(name, ...) duet_motion_##name(m, __VA_ARGS__)
#define DEF duet_motion_get_def(m)
#define GIVEN(rows) (rows)
#include "support/obey.inl"

// True where all the players did it.
static bool command_all(play *p, verb what, const order *o)
{
    uint64_t came[PLAYERS][ORDER_ROWS] = {{0}};
    duet_error errs[PLAYERS] = {{0}};
    bool first = false;
    for (int k = 0; k < PLAYERS; ++k) {
        bool ok = obey(p->movers[k]->motion, what, o, came[k], &errs[k]);
        first = k == 0 ? ok : first;
        if (ok != first || strcmp(errs[k].text, errs[0].text) != 0)
            fail_msg("command %d: player %d is told '%s', the first '%s'", what, k, errs[k].text,
                     errs[0].text);
        assert_memory_equal(came[k], came[0], sizeof came[0]);
    }
    if (!first && !strstr(errs[0].text, "mass of") && !strstr(errs[0].text, "is disabled"))
        fail_msg("command %d: %s", what, errs[0].text);
    if (first && what == ADD)
        orders_added(&p->orders, o, came[0]);
    return first;
}

static void command_once(play *p)
{
    const verb what = orders_verb(&p->orders);
    const uint32_t n = p->orders.known.n;
    order o = orders_draw(&p->orders, what);
    if ((what == ADD && n > n_bodies + n_bodies / 2) ||
        (what == REMOVE && n < n_bodies - n_bodies / 5) ||
        (what == CHANGE && rng_below(&p->orders.r, 4)))
        return;
    without_twins(&o);
    if (command_all(p, what, &o) && what == REMOVE)
        orders_removed(&p->orders, &o);
}

// By every call that takes ids, wherever the stale one is in the list.
static void assert_stale_ids_are_refused(play *p)
{
    if (p->orders.known.n_stale == 0)
        return;
    verb what = orders_verb(&p->orders);
    order o = orders_draw(&p->orders, SET);
    o.n = 2;
    o.ids[1] = orders_stale_id(&p->orders);
    if (what == ADD || what == CHANGE || what == AIM)
        what = REMOVE;
    duet_motion *m = p->movers[rng_below(&p->orders.r, PLAYERS)]->motion;
    assert_false(duet_motion_has_body(m, o.ids[1]));
    must_fail(obey(m, what, &o, NULL, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    if (!strstr(ERR->text, "was removed") && !strstr(ERR->text, "is disabled"))
        fail_msg("command %d with a stale id is told '%s'", what, ERR->text);
}

// One player goes on with what another saved, perhaps as one that is new, with a skin or without.
static void save_and_load(play *p)
{
    uint32_t from = rng_below(&p->orders.r, PLAYERS), to = rng_below(&p->orders.r, PLAYERS);
    must(duet_motion_save(p->movers[from]->motion, saved, ERR));
    if (rng_below(&p->orders.r, 2)) {
        mover_restart(p->movers[to]);
        mover_run(p->movers[to], 0);
    }
    must(duet_motion_load(p->movers[to]->motion, saved, ERR));
}

// All go back to where they were once, or will come back to where they are.
static void remember_or_go_back(play *p)
{
    for (int k = 0; k < PLAYERS; ++k) {
        duet_motion *m = p->movers[k]->motion;
        if (p->has_past)
            must(duet_motion_load(m, past, ERR));
        else if (k == 0)
            must(duet_motion_save(m, past, ERR));
    }
    if (p->has_past)
        p->orders.known = p->past;
    else
        p->past = p->orders.known;
    p->has_past = !p->has_past;
}

static void ask_all(play *p, int step)
{
    questions q = questions_random(&p->orders.r, p->kind == FLAT ? 2 : 3, p->orders.size);
    uint64_t first = 0;
    for (int k = 0; k < PLAYERS; ++k) {
        uint64_t sum = asker_ask(p->askers[k], p->movers[k]->motion, &q, k == step % PLAYERS);
        first = k == 0 ? sum : first;
        if (sum != first)
            fail_msg("player %d is answered otherwise after step %d", k, step);
    }
}

static void assert_all_are_equal(play *p, int step)
{
    uint64_t hash = mover_hash(p->movers[0]);
    for (int k = 1; k < PLAYERS; ++k)
        if (mover_hash(p->movers[k]) != hash)
            fail_msg("player %d differs after step %d", k, step);
    const duet_motion_result *first = &p->movers[0]->last;
    for (int k = 1; k < PLAYERS; ++k) {
        const duet_motion_result *last = &p->movers[k]->last;
        assert_true(last->n_events == first->n_events && last->n_stays == first->n_stays);
        for (uint64_t i = 0; i < first->n_events; ++i)
            assert_true(last->events[i].a == first->events[i].a &&
                        last->events[i].b == first->events[i].b &&
                        last->events[i].begins == first->events[i].begins);
    }
}

static void set_world(mover *m, world_kind kind, double size)
{
    duet_motion_def *d = &m->def;
    d->wants = DUET_EFFECT_FORCES | DUET_EFFECT_SLEEP | DUET_EFFECT_FILTER | DUET_EFFECT_SENSORS;
    d->sleep_after = 0.1;
    d->gravity[kind == FLAT ? 1 : 2] = -9.81;
    d->doubles = kind == DOUBLES || kind == FLIGHT;
    d->origin_edge = kind == PLACED ? 4 : 0;
    d->boundary = kind == PLACED ? DUET_BOUNDARY_NONE : DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k)
        d->upper[k] = k == (kind == FLAT ? 1 : 2) ? 40 + size : size;
    if (kind != FLIGHT)
        return;
    d->wants = DUET_EFFECT_FORCES;
    d->boundary = DUET_BOUNDARY_PERIODIC;
    d->integrator = DUET_INTEGRATOR_VERLET;
    d->skin = 0;
}

static play begin_play(world_kind kind, uint64_t seed)
{
    static const struct {
        uint32_t share;
        duet_mode mode;
        double skin;
    } ways[PLAYERS] = {
        {0, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE / 3, DUET_MODE_SHARED, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_SLAB, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_OWN, 0.2},
    };
    play p = {.kind = kind,
              .orders = {.r = rng_seed(seed),
                         .size = 12 * cbrt(n_bodies / 200.0), // so dense for any number
                         .is_flat = kind == FLAT,
                         .turns = true,
                         .touches = kind != FLIGHT,
                         .most = ORDER_ROWS,
                         .fields = DUET_BODY_ALL,
                         .known.n = n_bodies}};
    for (int k = 0; k < PLAYERS; ++k) {
        mover *m = p.movers[k] = mover_new(kind == FLAT ? 2 : 3);
        m->def.plan.share = ways[k].share;
        m->def.plan.mode = ways[k].mode;
        m->def.skin = ways[k].skin;
        set_world(m, p.kind, p.orders.size);
        m->n = n_bodies;
        rng r = p.orders.r;
        for (uint32_t i = 0; i < m->n; ++i) {
            m->poses[i] = orders_pose(&p.orders);
            m->bodies[i] = orders_body(&p.orders);
        }
        if (k + 1 < PLAYERS)
            p.orders.r = r;
        mover_run(m, 0);
        p.askers[k] = asker_open(m->def.pair, m->def.dims, ways[k].share);
    }
    for (uint32_t i = 0; i < n_bodies; ++i)
        p.orders.known.ids[i] = i;
    return p;
}

// Within its skin the last player searches about those only that commands altered.
static bool searched_some(const play *p)
{
    const duet_motion_result *last = &p->movers[PLAYERS - 1]->last;
    bool some = false, all = false;
    for (uint32_t i = 0; i < last->n_stages; ++i) {
        some |= strcmp(last->stages[i].name, "altered_pairs") == 0;
        all |= strcmp(last->stages[i].name, "pairs") == 0;
    }
    return some && !all;
}

// Players with an odd number make each step in two halves.
static void advance_all(play *p)
{
    for (int k = 1; k < PLAYERS; k += 2)
        must(duet_motion_advance_begin(p->movers[k]->motion, ERR));
    for (int k = 0; k < PLAYERS; ++k) {
        mover *m = p->movers[k];
        must(k % 2 ? duet_motion_advance_end(m->motion, &m->last, ERR)
                   : duet_motion_advance(m->motion, &m->last, ERR));
    }
}

// The state's hash at the end.
static uint64_t play_once(world_kind kind, int n_steps, uint64_t seed)
{
    play p = begin_play(kind, seed);
    for (int step = 0; step < n_steps; ++step) {
        for (uint32_t n = rng_below(&p.orders.r, 4); n > 0; --n)
            command_once(&p);
        assert_stale_ids_are_refused(&p);
        if (rng_below(&p.orders.r, 16) == 0)
            save_and_load(&p);
        if (rng_below(&p.orders.r, 24) == 0)
            remember_or_go_back(&p);
        advance_all(&p);
        p.n_searched_some += searched_some(&p);
        if (step % 5 == 0 || step + 1 == n_steps)
            assert_all_are_equal(&p, step);
        if (rng_below(&p.orders.r, 12) == 0)
            ask_all(&p, step);
    }
    print_message("world %d: %u bodies, %u places, %u stale ids, %u of %d steps search some\n",
                  kind, p.orders.known.n, duet_motion_get_count(p.movers[0]->motion),
                  p.orders.known.n_stale, p.n_searched_some, n_steps);
    assert_true(p.n_searched_some > 0 || kind != USUAL || n_steps < 100);
    uint64_t hash = mover_hash(p.movers[0]);
    for (int k = 0; k < PLAYERS; ++k)
        mover_free(p.movers[k]);
    return hash;
}

TEST(the_same_commands_give_the_same_bits)
{
    uint64_t seed = test_seed();
    for (int kind = first_world; kind < n_worlds; ++kind)
        play_once((world_kind)kind, n_fuzzed_steps, seed + (uint64_t)kind);
}

static void set_host_memory(bool host)
{
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory = host;
}

// Rows are then fetched, changed and sent back.
TEST(devices_with_memory_of_their_own_give_the_same_bits)
{
    uint64_t seed = test_seed();
    bool host = default_pair()->devices[1].info.host_memory;
    uint64_t hash = play_once(USUAL, 30, seed);
    set_host_memory(false);
    assert_true(play_once(USUAL, 30, seed) == hash);
    set_host_memory(host);
}

static void take_more(void)
{
    const char *how = test_argument(1), *world = test_argument(2);
    if (world && strcmp(how, "--world") == 0)
        first_world = atoi(world);
    if (how) {
        n_fuzzed_steps = 500;
        n_bodies = 2000;
        n_worlds = WORLD_KINDS;
    }
}

TEST_BEGIN(take_more)
