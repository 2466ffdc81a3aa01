// SPDX-License-Identifier: MIT
// Random commands, queries, saves and loads: the same bits with any plan, and the answers of
// a plain C twin. With --all they go to worlds of all kinds, and to many bodies.
#include "support/asker.h"
#include "support/commands.h"

#include "base/rng.h"
#include "runtime/opencl/device_pair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char saved[] = "saved";
static const char past[] = "past";

enum { PLAYERS = 5, MOST_IDS = 4096 };

static int n_fuzzed_steps = 120, first_world = 0, n_worlds = 1;
static uint32_t n_bodies = 200;

// Worlds that kernels and buffers differ in.
typedef enum world_kind { USUAL, FLAT, DOUBLES, PLACED, FLIGHT, WORLD_KINDS } world_kind;

// One stream of commands goes to motions with several plans.
typedef struct play {
    world_kind kind;
    rng r;
    double size; // edge of the world, so that bodies are as dense in each
    mover *movers[PLAYERS];
    asker *askers[PLAYERS];
    uint64_t ids[MOST_IDS], stale[MOST_IDS];
    uint32_t n_ids, n_stale;
    uint32_t n_searched_some; // steps of the last player
    struct {
        uint64_t ids[MOST_IDS], stale[MOST_IDS];
        uint32_t n_ids, n_stale;
        bool known;
    } past;
} play;

static float between(play *p, double from, double to)
{
    return (float)rng_between(&p->r, from, to);
}

static duet_pose random_pose(play *p)
{
    duet_pose pose = {.rotation = {between(p, -1, 1), between(p, -1, 1), between(p, -1, 1), 1}};
    if (p->kind == FLAT)
        pose.rotation[0] = pose.rotation[1] = 0;
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = between(p, 0.5, k == 2 ? p->size : p->size - 0.5);
        pose.half_extents[k] = between(p, 0.1, 0.4);
    }
    return pose;
}

static duet_body random_body(play *p)
{
    duet_body b = duet_default_body();
    for (int k = 0; k < 3; ++k) {
        b.velocity[k] = between(p, -3, 3);
        b.angular_velocity[k] = between(p, -3, 3);
    }
    b.mass = rng_below(&p->r, 8) ? between(p, 0.5, 3) : 0;
    if (b.mass == 0 && rng_below(&p->r, 2))
        memset(b.velocity, 0, sizeof b.velocity);
    if (p->kind == FLIGHT)
        return b;
    b.sensor = rng_below(&p->r, 12) == 0;
    b.friction = between(p, 0, 1);
    b.restitution = between(p, 0, 0.5);
    b.group = 1u << rng_below(&p->r, 3);
    return b;
}

enum { MOST_AT_ONCE = 12 };

// The arguments of one command.
typedef struct order {
    uint32_t n;
    uint64_t ids[MOST_AT_ONCE];
    duet_pose poses[MOST_AT_ONCE];
    duet_body bodies[MOST_AT_ONCE];
    duet_force forces[MOST_AT_ONCE];
    duet_impulse impulses[MOST_AT_ONCE];
    duet_transform targets[MOST_AT_ONCE];
    uint32_t fields;
    duet_motion_def def;
} order;

static order random_order(play *p)
{
    order o = {.n = 1 + rng_below(&p->r, MOST_AT_ONCE), .fields = rng_below(&p->r, DUET_BODY_ALL)};
    o.n = o.n < p->n_ids ? o.n : p->n_ids;
    uint32_t at = rng_below(&p->r, p->n_ids);
    for (uint32_t i = 0; i < o.n; ++i) {
        o.ids[i] = p->ids[(at + 7 * i) % p->n_ids];
        o.poses[i] = random_pose(p);
        o.bodies[i] = random_body(p);
        for (int k = 0; k < 3; ++k) {
            o.forces[i].force[k] = between(p, -30, 30);
            o.forces[i].torque[k] = between(p, -3, 3);
            o.impulses[i].impulse[k] = between(p, -2, 2);
            o.impulses[i].anchor[k] = between(p, -0.3, 0.3);
            o.targets[i].centre[k] = o.poses[i].centre[k];
        }
        memcpy(o.targets[i].rotation, o.poses[i].rotation, sizeof o.targets[i].rotation);
    }
    o.def = *duet_motion_get_def(p->movers[0]->motion);
    o.def.gravity[rng_below(&p->r, 3)] = between(p, -10, 2);
    return o;
}

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

static void forget_ids(play *p, const order *o)
{
    for (uint32_t i = 0; i < o->n; ++i) {
        uint32_t at = 0;
        while (p->ids[at] != o->ids[i])
            ++at;
        p->ids[at] = p->ids[--p->n_ids];
        p->stale[p->n_stale++ % MOST_IDS] = o->ids[i];
    }
}

typedef enum verb {
    ADD,
    REMOVE,
    SET,
    SET_POSES,
    FORCE,
    IMPULSE,
    AIM,
    DISABLE,
    ENABLE,
    PUT_TO_SLEEP,
    WAKE,
    CHANGE,
    VERBS
} verb;

// Some are refused, such as a target for what has a mass: by all alike.
static bool obey(verb what, duet_motion *m, const order *o, uint64_t *came, duet_error *err)
{
    const duet_body_list list = by_ids(o->ids, o->n);
    switch (what) {
    case ADD:
        return duet_motion_add_bodies(m, o->poses, o->bodies, o->n, came, err);
    case REMOVE:
        return duet_motion_remove_bodies(m, list, err);
    case SET:
        return duet_motion_set_bodies(m, list, o->fields, o->bodies, err);
    case SET_POSES:
        return duet_motion_set_poses(m, list, o->poses, err);
    case FORCE:
        return duet_motion_apply_forces(m, list, o->forces, err);
    case IMPULSE:
        return duet_motion_apply_impulses(m, list, o->impulses, err);
    case AIM:
        return duet_motion_set_targets(m, by_ids(o->ids, 1), o->targets, err);
    case DISABLE:
        return duet_motion_disable_bodies(m, list, err);
    case ENABLE:
        return duet_motion_enable_bodies(m, list, err);
    case PUT_TO_SLEEP:
        return duet_motion_sleep_bodies(m, list, err);
    case WAKE:
        return duet_motion_wake_bodies(m, list, err);
    default:
        return duet_motion_set_def(m, &o->def, err);
    }
}

// True where all the players did it.
static bool command_all(play *p, verb what, order *o)
{
    uint64_t came[PLAYERS][MOST_AT_ONCE] = {{0}};
    duet_error errs[PLAYERS] = {{0}};
    bool first = false;
    for (int k = 0; k < PLAYERS; ++k) {
        duet_motion *m = p->movers[k]->motion;
        o->def.plan = duet_motion_get_def(m)->plan;
        o->def.skin = duet_motion_get_def(m)->skin;
        bool ok = obey(what, m, o, came[k], &errs[k]);
        first = k == 0 ? ok : first;
        if (ok != first || strcmp(errs[k].text, errs[0].text) != 0)
            fail_msg("command %d: player %d is told '%s', the first '%s'", what, k, errs[k].text,
                     errs[0].text);
        assert_memory_equal(came[k], came[0], sizeof came[0]);
    }
    if (!first && !strstr(errs[0].text, "mass of") && !strstr(errs[0].text, "is disabled"))
        fail_msg("command %d: %s", what, errs[0].text);
    if (first && what == ADD)
        for (uint32_t i = 0; i < o->n; ++i)
            p->ids[p->n_ids++] = came[0][i];
    return first;
}

static void command_once(play *p)
{
    verb what = (verb)rng_below(&p->r, VERBS);
    if (p->kind == FLIGHT && (what == WAKE || what == PUT_TO_SLEEP))
        return;
    order o = random_order(p);
    if ((what == ADD && p->n_ids > n_bodies + n_bodies / 2) ||
        (what == REMOVE && p->n_ids < n_bodies - n_bodies / 5) ||
        (what == CHANGE && rng_below(&p->r, 4)))
        return;
    without_twins(&o);
    if (command_all(p, what, &o) && what == REMOVE)
        forget_ids(p, &o);
}

// By every call that takes ids, wherever the stale one is in the list.
static void assert_stale_ids_are_refused(play *p)
{
    if (p->n_stale == 0)
        return;
    order o = random_order(p);
    o.n = 2;
    o.ids[0] = p->ids[rng_below(&p->r, p->n_ids)];
    o.ids[1] = p->stale[rng_below(&p->r, p->n_stale < MOST_IDS ? p->n_stale : MOST_IDS)];
    verb what = (verb)rng_below(&p->r, VERBS);
    if (what == ADD || what == CHANGE || what == AIM)
        what = REMOVE;
    duet_motion *m = p->movers[rng_below(&p->r, PLAYERS)]->motion;
    assert_false(duet_motion_has_body(m, o.ids[1]));
    must_fail(obey(what, m, &o, NULL, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    if (!strstr(ERR->text, "was removed") && !strstr(ERR->text, "is disabled"))
        fail_msg("command %d with a stale id is told '%s'", what, ERR->text);
}

// One player goes on with what another saved, perhaps as one that is new, with a skin or without.
static void save_and_load(play *p)
{
    uint32_t from = rng_below(&p->r, PLAYERS), to = rng_below(&p->r, PLAYERS);
    assert_done(duet_motion_save(p->movers[from]->motion, saved, &err));
    if (rng_below(&p->r, 2)) {
        mover_restart(p->movers[to]);
        mover_run(p->movers[to], 0);
    }
    assert_done(duet_motion_load(p->movers[to]->motion, saved, &err));
}

// All go back to where they were once, or will come back to where they are.
static void remember_or_go_back(play *p)
{
    for (int k = 0; k < PLAYERS; ++k) {
        duet_motion *m = p->movers[k]->motion;
        if (p->past.known)
            assert_done(duet_motion_load(m, past, &err));
        else if (k == 0)
            assert_done(duet_motion_save(m, past, &err));
    }
    if (p->past.known) {
        memcpy(p->ids, p->past.ids, sizeof p->ids);
        memcpy(p->stale, p->past.stale, sizeof p->stale);
        p->n_ids = p->past.n_ids;
        p->n_stale = p->past.n_stale;
    } else {
        memcpy(p->past.ids, p->ids, sizeof p->ids);
        memcpy(p->past.stale, p->stale, sizeof p->stale);
        p->past.n_ids = p->n_ids;
        p->past.n_stale = p->n_stale;
    }
    p->past.known = !p->past.known;
}

static void ask_all(play *p, int step)
{
    questions q = questions_random(&p->r, p->kind == FLAT ? 2 : 3, p->size);
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
    play p = {.kind = kind, .r = rng_seed(seed), .n_ids = n_bodies};
    p.size = 12 * cbrt(n_bodies / 200.0);
    for (int k = 0; k < PLAYERS; ++k) {
        mover *m = p.movers[k] = mover_new(kind == FLAT ? 2 : 3);
        m->def.plan.share = ways[k].share;
        m->def.plan.mode = ways[k].mode;
        m->def.skin = ways[k].skin;
        set_world(m, p.kind, p.size);
        m->n = n_bodies;
        rng r = p.r;
        for (uint32_t i = 0; i < m->n; ++i) {
            m->poses[i] = random_pose(&p);
            m->bodies[i] = random_body(&p);
        }
        if (k + 1 < PLAYERS)
            p.r = r;
        mover_run(m, 0);
        p.askers[k] = asker_open(m->def.pair, m->def.dims, ways[k].share);
    }
    for (uint32_t i = 0; i < p.n_ids; ++i)
        p.ids[i] = i;
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
        for (uint32_t n = rng_below(&p.r, 4); n > 0; --n)
            command_once(&p);
        assert_stale_ids_are_refused(&p);
        if (rng_below(&p.r, 16) == 0)
            save_and_load(&p);
        if (rng_below(&p.r, 24) == 0)
            remember_or_go_back(&p);
        advance_all(&p);
        p.n_searched_some += searched_some(&p);
        if (step % 5 == 0 || step + 1 == n_steps)
            assert_all_are_equal(&p, step);
        if (rng_below(&p.r, 12) == 0)
            ask_all(&p, step);
    }
    print_message("world %d: %u bodies, %u places, %u stale ids, %u of %d steps search some\n",
                  kind, p.n_ids, duet_motion_get_count(p.movers[0]->motion), p.n_stale,
                  p.n_searched_some, n_steps);
    assert_true(p.n_searched_some > 0 || kind != USUAL || n_steps < 100);
    uint64_t hash = mover_hash(p.movers[0]);
    for (int k = 0; k < PLAYERS; ++k) {
        asker_close(p.askers[k]);
        mover_free(p.movers[k]);
    }
    return hash;
}

TEST(the_same_commands_give_the_same_bits)
{
    uint64_t seed = test_seed();
    print_message("DUET_TEST_SEED=%llu\n", (unsigned long long)seed);
    for (int kind = first_world; kind < n_worlds; ++kind)
        play_once((world_kind)kind, n_fuzzed_steps, seed + (uint64_t)kind);
}

static void set_host_memory(bool host)
{
    for (int side = 0; side < 2; ++side)
        mover_pair()->devices[side].info.host_memory = host;
}

// Rows are then fetched, changed and sent back.
TEST(devices_with_memory_of_their_own_give_the_same_bits)
{
    uint64_t seed = test_seed();
    bool host = mover_pair()->devices[1].info.host_memory;
    uint64_t hash = play_once(USUAL, 30, seed);
    set_host_memory(false);
    assert_true(play_once(USUAL, 30, seed) == hash);
    set_host_memory(host);
}

int main(int argc, char **argv)
{
    if (argc > 2 && strcmp(argv[1], "--world") == 0)
        first_world = atoi(argv[2]);
    if (argc > 1) {
        n_fuzzed_steps = 500;
        n_bodies = 2000;
        n_worlds = WORLD_KINDS;
    }
    return test_run(mover_open_pair, mover_close_pair);
}
